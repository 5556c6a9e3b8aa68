// The force on a running arm from its motor currents: live.py for C++17, without dependencies.
//
//   live::Live arm = live::Live::load("arm.json");
//   live::Answer now = arm.step(time, q, qd, current);  // now.wrench, now.std, now.contact
//
// `ur5 export --format live` writes arm.json. Equations, units and answers are those of live.py, whose
// names this file keeps; `step` neither allocates nor throws.
#pragma once

#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "live.hpp refuses samples by NaN and infinity: compile it without -ffast-math and -ffinite-math-only"
#endif

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <locale>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace live {

constexpr int MAX_JOINTS = 8, MAX_PARTS = 4, MAX_SIZES = 8, MAX_PLACES = 16;  // the last: on a link
enum Contact { FREE, SUSPECTED, CONTACT, UNKNOWN };
enum State { MOVING, REVERSING, SETTLING, RESTING, STILL, UNMOVED };
constexpr int STATE_COUNT = 6;
constexpr const char* STATES[STATE_COUNT] = {"moving", "reversing", "settling", "resting", "still", "unmoved"};
constexpr const char* FORMAT = "ur5lib live 5";
constexpr int KINDS = 3, LESS_GRAVITY = 2;  // of effort
constexpr const char* KIND_NAMES[KINDS] = {"current", "torque", "torque_less_gravity"};
constexpr const char* KIND_WORDS[KINDS] = {"currents [A]", "torques [Nm]", "torques less gravity [Nm]"};
constexpr double FIRST_MOTION = 1.0, LONGEST_MOTION = 2.0, CLEAR = 0.5;
// why nothing is known, or no wrench; from MISFIT on, by kind of effort
enum Why { KNOWN, UNUSABLE, STARTED, FAST, BLIND, ELSEWHERE, MISFIT };
constexpr const char* REASONS[MISFIT] = {
    "", "no usable sample came: all were lost, late, frozen, no numbers, or beyond what the arm can",
    "the run has just begun, so that friction may still settle",
    "a joint is faster than any that the study saw",
    "in this pose, resting joints hardly feel a force along some axis",
    "the arm is touched before its flange, so that no wrench at the flange is stated"};
constexpr int DEEPEST = 16;  // of a file: brackets in brackets, and sizes of its numbers
constexpr double LEAST = 1e-9, MOST = 1e9;
constexpr const char* CONSTANTS[] = {
    "gain",     "wide", "doubt",  "duration", "slows", "stopping", "release",     "thaw",   "slow",      "settle",
    "stop", "reversal", "missed", "press", "rest_speed", "moved", "dead_zone", "max_gap", "margin", "jump",
    "turns", "encoder", "acceleration", "window", "confirmed", "stays", "large", "blind", "faster", "least_step",
    "period"};
constexpr double NORMAL95 = 1.96, NORMAL99 = 2.576;  // so many standard deviations to either side have 95 %, 99 %
constexpr double LOOK = 0.05, SPACING = 0.1, TOOL = 0.2, SURFACE = 0.05, LOST = 0.15, AT_FLANGE = 0.75, LIKELY = 0.5;
constexpr int PLACE_SIZES = 2, LEAST_LOOKS = 4;
constexpr double PLACE_SIZE[PLACE_SIZES] = {1.0, 3.0};  // of contacts, in typical forces
constexpr int TERMS = 12, STRIBECK = 8, LOAD = 11;
constexpr const char* TERM_NAMES[TERMS] = {
    "coulomb", "viscous", "velocity_root", "velocity_square", "periodic_sin", "periodic_cos", "balance_sin",
    "balance_cos", "velocity_stribeck_slow", "velocity_stribeck_middle", "velocity_stribeck_fast", "load"};
constexpr double STRIBECK_SPEEDS[LOAD - STRIBECK] = {0.01, 0.05, 0.2};  // rad/s, as of the study
using Joints = std::array<double, MAX_JOINTS>;
using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;
using Wrench = std::array<double, 6>;
using Square = std::array<Wrench, 6>;

struct Answer {
  Wrench wrench{}, std{};
  Contact contact = UNKNOWN;
  Vector untouched{}, hidden{}, hidden_at_all{};  // as in live.py [N]
  int link = 0;                                   // of a contact in motion, the likeliest, from 1
  double off_flange = 0;                          // and the probability that it is not the last one
};

// why efforts of a kind are refused where `own` is expected, and what to do
inline std::string misfit(const std::string& given, const std::string& own) {
  const auto words = [](const std::string& kind) -> std::string {
    for (int k = 0; k < KINDS; ++k)
      if (kind == KIND_NAMES[k]) return KIND_WORDS[k];
    return "";
  };
  if (words(given).empty())
    return "unknown input '" + given + "'; available: auto, current, torque, torque_less_gravity";
  std::string remedy = "give `input` as " + given;
  if (given == KIND_NAMES[0] || own == KIND_NAMES[0])
    remedy = std::string("let the driver publish ") +
             (own == KIND_NAMES[0] ? "currents (a UR's: use_currents_as_efforts)" : "torques") +
             ", or identify the arm by such efforts";
  return "efforts are " + words(given) + ", but " + words(own) + " are expected; " + remedy;
}

inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector operator+(const Vector& a, const Vector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Vector operator*(const Matrix& m, const Vector& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}
inline Matrix transposed(const Matrix& m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}
inline Matrix operator*(const Matrix& a, const Matrix& b) {
  const Matrix c = transposed(b);
  Matrix product;
  for (int i = 0; i < 3; ++i) product[i] = {dot(a[i], c[0]), dot(a[i], c[1]), dot(a[i], c[2])};
  return product;
}
inline double sign(double x) { return (x > 0) - (x < 0); }

// The numbers of an arm's file by their place, as "links.0.mass". Reads what live.py reads: JSON in UTF-8
// without NaN, keys that stand there twice, or over 16 brackets in brackets; else throws.
class Numbers {
 public:
  explicit Numbers(std::string text) : text_(std::move(text)) {
    if (!utf8()) refuse("its text");
    value("", 0);
    space();
    if (at_ != text_.size()) refuse("its end");
  }
  double at(const std::string& place) const {
    const auto found = values_.find(place);
    if (found == values_.end()) refuse(place);
    return found->second;
  }
  int count(const std::string& place) const {
    const auto found = counts_.find(place);
    return found == counts_.end() ? -1 : found->second;
  }
  bool has(const std::string& place) const { return seen_.count(place) > 0; }
  bool says(const std::string& place, const std::string& word) const {
    const auto found = words_.find(place);
    return found != words_.end() && found->second == word;
  }
  Joints joints(const std::string& place, int n) const {
    Joints row{};
    for (int k = 0; k < n; ++k) row[k] = at(place + "." + std::to_string(k));
    return row;
  }
  // throws where a list of lists of such sizes is none, or a number in it is out of its range
  void expect(const std::string& place, std::vector<int> shape, double least, double most = MOST) const {
    if (shape.empty()) {
      const double number = at(place);
      if (!(least <= number && number <= most)) refuse(place);
      return;
    }
    const int size = shape.front();
    if (count(place) != size) refuse(place);
    shape.erase(shape.begin());
    for (int k = 0; k < size; ++k) expect(place + "." + std::to_string(k), shape, least, most);
  }
  [[noreturn]] static void refuse(const std::string& what) {
    throw std::runtime_error(what + ": not as `ur5 export --format live` writes it; export the file again");
  }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void space() {
    while (at_ < text_.size() && std::string(" \t\n\r").find(text_[at_]) != std::string::npos) ++at_;
  }
  void expect_char(char c) {
    space();
    if (peek() != c || at_ >= text_.size()) refuse("its text");
    ++at_;
  }
  bool utf8() const {
    for (std::size_t i = 0; i < text_.size();) {
      const auto byte = [this](std::size_t k) { return k < text_.size() ? static_cast<unsigned char>(text_[k]) : 0u; };
      const unsigned first = byte(i);
      const int more = first < 0x80 ? 0 : first >= 0xC2 && first < 0xE0 ? 1 : first >= 0xE0 && first < 0xF0 ? 2
                     : first >= 0xF0 && first < 0xF5 ? 3 : -1;
      if (more < 0) return false;
      for (int k = 1; k <= more; ++k)
        if ((byte(i + k) & 0xC0) != 0x80) return false;
      const unsigned second = byte(i + 1);  // none too long, no surrogate, none above U+10FFFF
      if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F)) return false;
      if ((first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) return false;
      i += 1 + more;
    }
    return true;
  }
  std::string text() {
    std::string word;
    expect_char('"');
    for (;; ++at_) {
      const char c = peek();
      if (at_ >= text_.size() || static_cast<unsigned char>(c) < 0x20) refuse("its text");
      if (c == '"') break;
      if (c != '\\') {
        word += c;
        continue;
      }
      ++at_;
      const std::size_t which = std::string("\"\\/bfnrtu").find(peek());
      if (at_ >= text_.size() || which == std::string::npos) refuse("its text");
      if (which < 8) {
        word += "\"\\/\b\f\n\r\t"[which];
        continue;
      }
      unsigned code = 0;
      for (int k = 0; k < 4; ++k) {
        ++at_;
        if (!std::isxdigit(static_cast<unsigned char>(peek()))) refuse("its text");
        code = 16 * code + static_cast<unsigned>(std::stoi(std::string(1, peek()), nullptr, 16));
      }
      if (code < 0x80) {
        word += static_cast<char>(code);
      } else {
        if (code >= 0x800) word += static_cast<char>(0xE0 | code >> 12);
        word += static_cast<char>(code >= 0x800 ? 0x80 | (code >> 6 & 0x3F) : 0xC0 | code >> 6);
        word += static_cast<char>(0x80 | (code & 0x3F));
      }
    }
    ++at_;
    return word;
  }
  void number(const std::string& place) {
    const std::size_t start = at_;
    const auto digits = [this] {
      if (!is_digit(peek())) refuse("its text");
      while (is_digit(peek())) ++at_;
    };
    if (peek() == '-') ++at_;
    if (peek() == '0') ++at_; else digits();
    if (peek() == '.') ++at_, digits();
    if (peek() == 'e' || peek() == 'E') {
      ++at_;
      if (peek() == '+' || peek() == '-') ++at_;
      digits();
    }
    std::istringstream word(text_.substr(start, at_ - start));
    word.imbue(std::locale::classic());  // whatever decimal comma the program has
    double found = 0;
    if (!(word >> found)) found = std::numeric_limits<double>::infinity();
    values_[place] = found;
  }
  void value(const std::string& place, int depth) {
    space();
    const char first = peek();
    if (first == '{' || first == '[') {
      if (depth == DEEPEST) refuse("brackets in brackets");
      const char end = first == '{' ? '}' : ']';
      int count = 0;
      ++at_;
      for (space(); peek() != end; space()) {
        if (count > 0) expect_char(',');
        space();
        std::string key = std::to_string(count++);
        if (end == '}') {
          key = text();
          std::replace(key.begin(), key.end(), '.', '\1');  // no place
          expect_char(':');
        }
        const std::string inner = place.empty() ? key : place + "." + key;
        if (!seen_.insert(inner).second) refuse("a key, twice");
        value(inner, depth + 1);
      }
      ++at_;
      if (end == ']') counts_[place] = count;
    } else if (first == '"') {
      words_[place] = text();
    } else if (first == '-' || is_digit(first)) {
      number(place);
    } else {
      for (const std::string word : {"true", "false", "null"})
        if (text_.compare(at_, word.size(), word) == 0) {
          at_ += word.size();
          return;
        }
      refuse("its text");
    }
  }
  std::string text_;
  std::size_t at_ = 0;
  std::set<std::string> seen_;
  std::map<std::string, double> values_;
  std::map<std::string, std::string> words_;
  std::map<std::string, int> counts_;
};

// Throws where a number lacks that the estimator needs, or cannot be right.
inline void check(const Numbers& arm) {
  const auto some = [&arm](const std::string& place, std::vector<int> shape) { arm.expect(place, shape, -MOST); };
  const auto part = [&arm](const std::string& place, std::vector<int> shape) { arm.expect(place, shape, 0.0); };
  const auto positive = [&arm](const std::string& place, std::vector<int> shape) { arm.expect(place, shape, LEAST); };
  const int n = arm.count("links"), parts = arm.count("friction.presliding"), sizes = arm.count("contacts.sizes");
  if (!arm.says("format", FORMAT)) Numbers::refuse("format");
  if (n < 1 || n > MAX_JOINTS || parts < 1 || parts > MAX_PARTS || sizes < 1 || sizes > MAX_SIZES)
    Numbers::refuse("links, presliding or sizes");
  for (int k = 0; k < n; ++k) {
    const std::string link = "links." + std::to_string(k) + ".";
    part(link + "mass", {});
    for (const char* name : {"position", "center_of_mass"}) some(link + name, {3});
    for (const char* name : {"rotation", "inertia"}) some(link + name, {3, 3});
  }
  double share = 0, load = 0, largest = 0;
  for (int k = 0; k < parts; ++k) {
    const std::string place = "friction.presliding." + std::to_string(k) + ".";
    positive(place + "distance", {});
    part(place + "share", {});
    some(place + "held", {n});
    share += arm.at(place + "share");
  }
  for (const std::string name : TERM_NAMES) {
    const std::string place = "friction.terms." + name;
    if (name == "coulomb" || name == "load" || arm.has(place)) some(place, {n});
  }
  for (const std::string state : STATES) {
    positive("noise.std." + state, {n});
    part("noise.absorbed." + state, {n});
    part("noise.hidden." + state, {n});
  }
  bool known = false;
  for (const char* kind : KIND_NAMES) known = known || arm.says("input", kind);
  if (!known) Numbers::refuse("input");
  for (const char* name : {"torque_constant", "motor_constant", "breakaway", "speed", "current"}) positive(name, {n});
  for (const char* name : {"rotor_inertia", "offset"}) some(name, {n});
  for (const char* name : {"gravity", "contacts.place"}) some(name, {3});
  for (const char* name : {"noise.shift", "contacts.lever", "contacts.typical"}) positive(name, {});
  for (const std::string name : CONSTANTS) positive("constants." + name, {});
  for (const char* name : {"threshold.log_odds", "constants.freeze", "constants.hysteresis"}) some(name, {});
  if (arm.has("threshold.before_flange")) some("threshold.before_flange", {});
  arm.expect("constants.rare", {}, LEAST, 1 - LEAST);
  positive("constants.quiet", {1});
  positive("contacts.sizes", {sizes});
  for (int k = 0; k < n; ++k) load = std::max(load, std::abs(arm.at("friction.terms.load." + std::to_string(k))));
  for (int k = 0; k < sizes; ++k) largest = std::max(largest, arm.at("contacts.sizes." + std::to_string(k)));
  if (load * share >= 1) Numbers::refuse("friction.terms.load");
  if (largest < arm.at("contacts.typical")) Numbers::refuse("contacts.typical");
}

struct Sweep {
  Joints momentum{}, rate{}, gravity{};
  std::array<Wrench, MAX_JOINTS> jacobian{};  // of the place of contacts, a column for each joint
  Vector place{};                             // from the last frame's origin, base axes [m]
  std::array<Vector, MAX_JOINTS + 2> frames{};  // origins of frames 0 to n, a tool's tip, from that place [m]
};

class Live {
 public:
  int n = 0;
  double evidence = 0, before_flange = 0;
  Joints observed{}, torque{};
  std::array<int, MAX_JOINTS> state{};

  // input: what is given as effort, "auto" for what the file states; throws where the arm was identified in
  // another unit
  explicit Live(const Numbers& arm, const std::string& input = "auto") {
    n = arm.count("links");
    for (int k = 0; k < KINDS; ++k) {
      if (arm.says("input", KIND_NAMES[k])) stated_ = k;
    }
    own_ = input == "auto" ? stated_ : -1;
    for (int k = 0; k < KINDS; ++k)
      if (input == KIND_NAMES[k]) own_ = k;
    if (own_ < 0 || (own_ != stated_ && (own_ == 0 || stated_ == 0)))
      throw std::runtime_error(misfit(input, KIND_NAMES[stated_]));
    for (int k = 0; k < KINDS; ++k) misfits_[k] = misfit(KIND_NAMES[k], KIND_NAMES[own_]);
    for (int k = 0; k < n; ++k) motor_[k] = arm.at("motor_constant." + std::to_string(k));
    for (int k = 0; k < n; ++k) {
      const std::string link = "links." + std::to_string(k) + ".";
      mass_[k] = arm.at(link + "mass");
      for (int i = 0; i < 3; ++i) {
        const std::string row = "." + std::to_string(i);
        tail_[k][i] = arm.at(link + "position" + row);
        center_[k][i] = arm.at(link + "center_of_mass" + row);
        for (int j = 0; j < 3; ++j) {
          const std::string entry = row + "." + std::to_string(j);
          turn_[k][i][j] = arm.at(link + "rotation" + entry);
          inertia_[k][i][j] = arm.at(link + "inertia" + entry);
        }
      }
    }
    for (int i = 0; i < 3; ++i) gravity_[i] = arm.at("gravity." + std::to_string(i));
    rotor_ = arm.joints("rotor_inertia", n);
    constant_ = arm.joints("torque_constant", n);
    offset_ = arm.joints("offset", n);
    breakaway_ = arm.joints("breakaway", n);
    fastest_ = arm.joints("speed", n);
    strongest_ = arm.joints("current", n);
    for (int t = 0; t < TERMS; ++t) {
      const std::string place = std::string("friction.terms.") + TERM_NAMES[t];
      if (arm.has(place)) terms_[t] = arm.joints(place, n);
      stribeck_ = stribeck_ || (STRIBECK <= t && t < LOAD && arm.has(place));
    }
    parts_ = arm.count("friction.presliding");
    for (int p = 0; p < parts_; ++p) {
      const std::string part = "friction.presliding." + std::to_string(p);
      distance_[p] = arm.at(part + ".distance");
      share_[p] = arm.at(part + ".share");
      held_[p] = arm.joints(part + ".held", n);
    }
    for (int s = 0; s < STATE_COUNT; ++s) {
      noise_[s] = arm.joints(std::string("noise.std.") + STATES[s], n);
      hidden_[s] = arm.joints(std::string("noise.hidden.") + STATES[s], n);
      absorbed_[s] = arm.joints(std::string("noise.absorbed.") + STATES[s], n);
    }
    threshold_ = arm.at("threshold.log_odds"), shift_ = arm.at("noise.shift");
    const std::string before = "threshold.before_flange";
    threshold_before_ = arm.has(before) ? arm.at(before) : std::numeric_limits<double>::infinity();
    const auto constant = [&arm](const char* name) { return arm.at(std::string("constants.") + name); };
    period_ = constant("period"), max_gap_ = constant("max_gap"), turns_ = constant("turns");
    margin_ = constant("margin"), jump_ = constant("jump"), gain_ = constant("gain");
    acceleration_ = constant("acceleration"), encoder_ = constant("encoder");
    dead_zone_ = constant("dead_zone"), rest_speed_ = constant("rest_speed");
    stop_ = constant("stop"), settle_ = constant("settle"), reversal_ = constant("reversal");
    wide_ = constant("wide"), doubt_ = constant("doubt"), rare_ = constant("rare");
    duration_ = constant("duration"), hysteresis_ = constant("hysteresis");
    slows_ = constant("slows"), stopping_ = constant("stopping"), release_ = constant("release");
    hiding_ = constant("missed"), press_ = constant("press");
    freeze_ = constant("freeze"), thaw_ = constant("thaw"), slow_ = constant("slow");
    window_ = constant("window"), confirmed_ = constant("confirmed"), stays_ = constant("stays");
    large_ = constant("large"), blind_ = constant("blind"), faster_ = constant("faster");
    least_step_ = constant("least_step"), moved_ = constant("moved");
    quiet_ = arm.at("constants.quiet.0");
    lever_ = arm.at("contacts.lever"), typical_ = arm.at("contacts.typical");
    for (int i = 0; i < 3; ++i) place_[i] = arm.at("contacts.place." + std::to_string(i));
    count_ = arm.count("contacts.sizes");
    for (int s = 0; s < count_; ++s) sizes_[s] = arm.at("contacts.sizes." + std::to_string(s));
    double total = 0;
    for (int s = 0; s < PLACE_SIZES; ++s) {
      place_size_[s] = PLACE_SIZE[s] * typical_;
      total += 1 / (place_size_[s] * place_size_[s]);
    }
    for (int k = 0; k < n; ++k) {
      const int parts = places(k);
      const double share = k + 1 == n ? AT_FLANGE : (1 - AT_FLANGE) / std::max(1, n - 1);
      for (int s = 0; s < PLACE_SIZES && parts > 0; ++s)  // p(size) falls as its square
        likely_[k][s] = std::log(share / parts) - 2 * std::log(place_size_[s]) - std::log(total);
    }
    restart();
  }

  static Live load(const std::string& path, const std::string& input = "auto") {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot read " + path);
    std::ostringstream text;
    text << file.rdbuf();
    const Numbers arm(text.str());
    check(arm);
    return Live(arm, input);
  }

  // why nothing is known, in words; empty where something is
  const char* reason() const noexcept { return why_ < MISFIT ? REASONS[why_] : misfits_[why_ - MISFIT].c_str(); }

  void restart() noexcept {
    efforts_ = Efforts{};
    refused_ = -1;
    forget();
  }

  // q, qd, current: n numbers each; qd: nullptr where the controller states no velocity; current: of the kind
  // `input`, in Nm for torques
  const Answer& step(double time, const double* q, const double* qd, const double* current) noexcept {
    const double* rates = qd;
    if (usable(time, q, qd, current)) {
      missed_ = 0;
      take(time, q, qd, current);
      rates = qd_.data();
    } else if (++missed_ * period_ > max_gap_) {
      forget();
    }
    if (rates != nullptr) fit(time, q, rates, current);
    if (refused_ >= 0) nothing(MISFIT + refused_);
    return answer_;
  }

  Sweep sweep(const double* q, const double* qd) const noexcept {
    Sweep result;
    std::array<Vector, MAX_JOINTS> axis, arm, omega, v, angular, linear, pull, weight;
    Matrix pose{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vector origin{}, turning{}, moving{};
    for (int k = 0; k < n; ++k) {
      const double c = std::cos(q[k]), s = std::sin(q[k]);
      const Matrix axes = pose * Matrix{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
      axis[k] = {pose[0][2], pose[1][2], pose[2][2]};
      arm[k] = cross(origin, axis[k]);
      omega[k] = turning = turning + qd[k] * axis[k];
      v[k] = moving = moving + qd[k] * arm[k];
      const Vector center = origin + axes * center_[k];
      linear[k] = mass_[k] * (moving + cross(turning, center));
      angular[k] = axes * (inertia_[k] * (transposed(axes) * turning)) + cross(center, linear[k]);
      weight[k] = mass_[k] * gravity_;
      pull[k] = cross(center, weight[k]);
      result.frames[k] = origin;
      origin = origin + axes * tail_[k];
      pose = axes * turn_[k];
    }
    result.place = pose * place_;
    const Vector touched = origin + result.place;
    result.frames[n] = origin;
    result.frames[n + 1] = origin + TOOL * Vector{pose[0][2], pose[1][2], pose[2][2]};
    for (int k = 0; k < n + 2; ++k) result.frames[k] = result.frames[k] + -1.0 * touched;
    for (int k = n - 1; k >= 0; --k) {
      if (k + 1 < n) {
        angular[k] = angular[k] + angular[k + 1];
        linear[k] = linear[k] + linear[k + 1];
        pull[k] = pull[k] + pull[k + 1];
        weight[k] = weight[k] + weight[k + 1];
      }
      result.momentum[k] = dot(axis[k], angular[k]) + dot(arm[k], linear[k]) + rotor_[k] * qd[k];
      result.gravity[k] = -(dot(axis[k], pull[k]) + dot(arm[k], weight[k]));
      result.rate[k] = dot(angular[k], cross(omega[k], axis[k])) +
                       dot(linear[k], cross(omega[k], arm[k]) + cross(v[k], axis[k])) - result.gravity[k];
      const Vector lift = arm[k] + cross(axis[k], touched);
      for (int i = 0; i < 3; ++i) {
        result.jacobian[k][i] = lift[i];
        result.jacobian[k][3 + i] = axis[k][i];
      }
    }
    return result;
  }

 private:
  using Densities = std::array<std::array<std::array<double, PLACE_SIZES>, MAX_PLACES>, MAX_JOINTS>;
  struct Posterior {
    std::array<double, MAX_SIZES> density{};
    std::array<Wrench, MAX_SIZES> mean{}, variance{};
  };

  // of all kinds of effort, whether another fits the motion far better than the own one
  struct Efforts {
    bool runs = false, fit = false;
    double time = 0, motion = 0;
    std::array<double, KINDS> loss{};
    std::array<Joints, MAX_PARTS> direction{};
    Joints momentum{};
    std::array<Joints, KINDS> rate{}, observed{};
  };

  void forget() noexcept {
    runs_ = false;
    passed_ = rested_ = evidence = 0;
    q_ = qd_ = lag_ = momentum_ = rate_ = observed = Joints{};
    friction_ = drift_ = scale_ = rest_ = settled_ = torque = Joints{};
    anchor_ = pull_ = low_ = high_ = speed_ = Joints{};
    direction_ = {};
    state.fill(MOVING);
    touched_ = at_rest_ = still_ = touched_before_ = at_flange_ = false;
    odds_ = before_flange = look_at_ = -std::numeric_limits<double>::infinity();
    looks_ = 0;
    seen_density_ = {};
    moved_at_ = -std::numeric_limits<double>::infinity();
    felt_at_ = std::numeric_limits<double>::infinity();
    missed_ = 0;
    nothing(UNUSABLE);
    sure_wrench_ = answer_.wrench;
    sure_std_ = answer_.std;
  }

  void nothing(int why) noexcept {
    answer_ = Answer{};
    why_ = why;
    largest_ = *std::max_element(sizes_.begin(), sizes_.begin() + count_);
    answer_.std = unknown_std();
    limit(std::array<Wrench, MAX_JOINTS>{});
  }

  Wrench unknown_std() const noexcept {
    Wrench std{};
    for (int i = 0; i < 6; ++i) std[i] = (i < 3 ? 1.0 : lever_) * largest_;
    return std;
  }

  bool possible(double time, const double* q, const double* qd) const noexcept {
    if (!(std::abs(time) < 1e12)) return false;
    for (int k = 0; k < n; ++k) {
      if (!(std::abs(q[k]) < turns_)) return false;
      if (qd != nullptr && !(std::abs(qd[k]) <= margin_ * fastest_[k])) return false;
    }
    return true;
  }

  double factor(int kind, int joint) const noexcept {
    if ((kind == 0) == (stated_ == 0)) return 1.0;
    return kind == 0 ? motor_[joint] : 1 / motor_[joint];
  }

  void fit(double time, const double* q, const double* qd, const double* effort) noexcept {
    for (int k = 0; k < n; ++k)
      if (!std::isfinite(effort[k])) return;
    if (!possible(time, q, qd)) return;
    if (efforts_.runs && std::abs(time - efforts_.time) > max_gap_) {
      efforts_ = Efforts{};
      refused_ = -1;
    }
    Efforts& own = efforts_;
    const bool first = !own.runs;
    const double passed = first ? 0.0 : time - own.time;
    if (own.fit || (!first && passed < least_step_)) {
      if (passed > 0) own.time = time;
      return;
    }
    own.runs = true;
    own.time = time;
    for (int p = 0; p < parts_; ++p)
      for (int k = 0; k < n; ++k) {
        const double kept = std::exp(-std::abs(qd[k]) * passed / distance_[p]);
        own.direction[p][k] = kept * own.direction[p][k] + (1 - kept) * sign(qd[k]);
      }
    const Sweep swept = sweep(q, qd);
    const double gain = gain_ * passed / (1 + gain_ * passed);
    std::array<double, KINDS> loss{};
    bool all_slow = true;
    for (int k = 0; k < n; ++k) {
      const bool slow = std::abs(qd[k]) < rest_speed_;
      all_slow = all_slow && slow;
      const double std = slow ? noise_[RESTING][k] + breakaway_[k] : noise_[MOVING][k];
      const Rubbing rubbing = rubs(k, q[k], qd[k], own.direction);
      for (int kind = 0; kind < KINDS; ++kind) {
        const double given = factor(kind, k) * (effort[k] + (kind == LESS_GRAVITY ? swept.gravity[k] : 0.0));
        const double rate = passed_on(k, given, rubbing) + swept.rate[k];
        double& seen = own.observed[kind][k];
        if (!first) {
          const double change = (swept.momentum[k] - own.momentum[k]) / passed - (rate + own.rate[kind][k]) / 2;
          seen += gain * (change - seen);
        }
        own.rate[kind][k] = rate;
        loss[kind] += std::log1p(seen / std * (seen / std)) / n;
      }
      own.momentum[k] = swept.momentum[k];
    }
    if (!first && !all_slow) weigh(passed, loss);
  }

  void weigh(double passed, const std::array<double, KINDS>& loss) noexcept {
    Efforts& own = efforts_;
    own.motion += passed;
    int best = -1;
    for (int kind = 0; kind < KINDS; ++kind) {
      own.loss[kind] += passed * loss[kind];
      if (kind != own_ && (best < 0 || own.loss[kind] < own.loss[best])) best = kind;
    }
    if (own.motion < FIRST_MOTION) return;
    const double lead = (own.loss[best] - own.loss[own_]) / own.motion;
    if (lead > CLEAR) own.fit = true, refused_ = -1;
    if (-lead > CLEAR) refused_ = best;
    if (own.motion <= LONGEST_MOTION) return;
    for (double& one : own.loss) one *= LONGEST_MOTION / own.motion;
    own.motion = LONGEST_MOTION;
  }

  bool usable(double time, const double* q, const double* qd, const double* current) noexcept {
    if (!possible(time, q, qd)) return false;
    for (int k = 0; k < n; ++k)
      if (!(std::abs(current[k]) <= margin_ * strongest_[k])) return false;
    const bool again = seen_ && repeats(q, qd, current);
    std::copy(q, q + n, last_q_.begin());
    std::copy(current, current + n, last_current_.begin());
    seen_ = true;
    if (again || !runs_) return !again;
    const double passed = time - time_;
    if (std::abs(passed) > max_gap_) {
      forget();
      return true;
    }
    if (!(passed >= least_step_)) return false;
    for (int k = 0; k < n; ++k)
      if (!(std::abs(q[k] - q_[k]) <= margin_ * fastest_[k] * passed + jump_)) return false;
    return true;
  }

  // whether positions or currents stay to the last bit while the arm moves
  bool repeats(const double* q, const double* qd, const double* current) const noexcept {
    bool moves = false, same_q = true, same_current = true;
    for (int k = 0; k < n; ++k) {
      moves = moves || (qd != nullptr && std::abs(qd[k]) > rest_speed_);
      same_q = same_q && q[k] == last_q_[k];
      same_current = same_current && current[k] == last_current_[k];
    }
    return moves && (same_q || same_current);
  }

  void start(double time) noexcept {
    time_ = started_ = below_at_ = above_at_ = suspected_at_ = time;
    fast_at_.fill(time);
    slow_at_.fill(-std::numeric_limits<double>::infinity());
  }

  void take(double time, const double* q, const double* qd, const double* current) noexcept {
    const bool first = !runs_;
    if (first) start(time);
    runs_ = true;
    passed_ = time - time_;
    velocity(q, qd, first);
    time_ = time;
    std::copy(q, q + n, q_.begin());
    const double share = passed_ / (window_ + passed_), quick = passed_ / (duration_ + passed_);
    for (int k = 0; k < n; ++k) {
      anchor_[k] = first ? q[k] : anchor_[k] + share * (q[k] - anchor_[k]);
      low_[k] = first ? q[k] : std::min(low_[k], q[k]);
      high_[k] = first ? q[k] : std::max(high_[k], q[k]);
      speed_[k] += quick * (std::abs(qd_[k]) - speed_[k]);
    }
    for (int p = 0; p < parts_; ++p)
      for (int k = 0; k < n; ++k) {
        const double kept = std::exp(-std::abs(qd_[k]) * passed_ / distance_[p]);
        direction_[p][k] = kept * direction_[p][k] + (1 - kept) * sign(qd_[k]);
      }
    const Sweep swept = sweep(q_.data(), qd_.data());
    Joints load, friction;
    gears(current, swept.gravity, load, friction);
    const double gain = gain_ * passed_ / (1 + gain_ * passed_);
    for (int k = 0; k < n; ++k) {
      const double rate = load[k] + swept.rate[k];
      if (first) {
        friction_[k] = friction[k];
      } else {
        const double change = (swept.momentum[k] - momentum_[k]) / passed_ - (rate + rate_[k]) / 2;
        observed[k] += gain * (change - observed[k]);
        friction_[k] += gain * (friction[k] - friction_[k]);
      }
      momentum_[k] = swept.momentum[k];
      rate_[k] = rate;
    }
    move();
    judge(swept);
    learn();
  }

  void velocity(const double* q, const double* qd, bool first) noexcept {
    const double index = passed_ * passed_ * acceleration_ / encoder_;
    const double root = (4 + index - std::sqrt(index * (8 + index))) / 4;
    for (int k = 0; k < n; ++k) {
      if (qd != nullptr) {
        qd_[k] = qd[k];
      } else if (first) {
        qd_[k] = 0;
      } else {
        const double innovation = lag_[k] + q[k] - q_[k] - passed_ * qd_[k];
        lag_[k] = root * root * innovation;
        qd_[k] += 2 * (1 - root) * (1 - root) / passed_ * innovation;
      }
    }
  }

  struct Rubbing {
    double z, own;  // direction of dry friction, and friction without its part by the load
  };

  Rubbing rubs(int k, double angle, double v, const std::array<Joints, MAX_PARTS>& direction) const noexcept {
    const double sine = std::sin(angle), cosine = std::cos(angle);
    double z = 0, held = 0;
    for (int p = 0; p < parts_; ++p) {
      z += share_[p] * direction[p][k];
      held += held_[p][k] * direction[p][k];
    }
    const double columns[STRIBECK] = {z,    v,      std::sqrt(std::abs(v)) * sign(v), std::abs(v) * v,
                                      sine, cosine, sine,                             cosine};
    double own = held * (1 - std::abs(std::tanh(v / dead_zone_)));
    for (int t = 0; t < STRIBECK; ++t) own += terms_[t][k] * columns[t];
    for (int t = STRIBECK; t < LOAD && stribeck_; ++t)
      own += terms_[t][k] * z * std::exp(-std::abs(v) / STRIBECK_SPEEDS[t - STRIBECK]);
    return {z, own};
  }

  // the torque that gears pass on
  double passed_on(int k, double current, const Rubbing& rubbing) const noexcept {
    const double torque = constant_[k] * current - offset_[k] - rubbing.own;
    return torque / (1 + terms_[LOAD][k] * rubbing.z * sign(torque));
  }

  void gears(const double* current, const Joints& gravity, Joints& load, Joints& friction) const noexcept {
    for (int k = 0; k < n; ++k) {
      const double given = own_ == LESS_GRAVITY ? current[k] + gravity[k] : current[k];
      load[k] = passed_on(k, given, rubs(k, q_[k], qd_[k], direction_));
      friction[k] = constant_[k] * given - offset_[k] - load[k];
    }
  }

  void move() noexcept {
    at_rest_ = still_ = true;
    bool all_slow = true;
    for (int k = 0; k < n; ++k) {
      const bool slow = std::abs(qd_[k]) < rest_speed_;
      if (!slow) fast_at_[k] = time_;
      if (slow) slow_at_[k] = time_;
      all_slow = all_slow && time_ > fast_at_[k];
      at_rest_ = at_rest_ && time_ - fast_at_[k] >= stop_;
    }
    if (!at_rest_) rested_ = 0;
    for (int k = 0; k < n; ++k) {
      if (all_slow)
        state[k] = rested_ >= settle_ ? STILL : SETTLING;
      else if (time_ - fast_at_[k] >= stop_)
        state[k] = RESTING;
      else
        state[k] = time_ - slow_at_[k] <= reversal_ ? REVERSING : MOVING;
      // to which side friction holds the joint, nobody knows yet
      if ((state[k] == REVERSING || state[k] == RESTING) && high_[k] - low_[k] <= moved_) state[k] = UNMOVED;
      still_ = still_ && state[k] == STILL;
    }
  }

  void judge(const Sweep& swept) noexcept {
    const std::array<Wrench, MAX_JOINTS>& jacobian = swept.jacobian;
    const Vector& place = swept.place;
    Joints variance{}, wider{}, touching{}, carried{};
    bool doubtful = time_ - started_ < settle_, fast = false;
    for (int k = 0; k < n; ++k) {
      torque[k] = observed[k] - (state[k] >= STILL ? rest_[k] : drift_[k] + scale_[k] * friction_[k]);
      const double unseen = std::max(std::abs(qd_[k]) / fastest_[k], 1.0);
      fast = fast || std::abs(qd_[k]) > faster_ * fastest_[k];
      const double own = noise_[state[k]][k] * unseen, lost = hidden_[state[k]][k];
      variance[k] = own * own;
      wider[k] = wide_ * wide_ * variance[k];
      touching[k] = variance[k] + lost * lost;
      carried[k] = torque[k] + absorbed_[state[k]][k] * std::tanh(torque[k] / breakaway_[k]);
    }
    const Posterior alone = posterior(torque, jacobian, variance, &quiet_, 1, lever_, false);
    const Posterior apart = posterior(torque, jacobian, wider, &quiet_, 1, lever_, false);
    const double still = std::log(1 - rare_) + alone.density[0], wide = std::log(rare_) + apart.density[0];
    const double free = std::max(still, wide) + std::log1p(std::exp(-std::abs(still - wide)));
    const Posterior touch = posterior(carried, jacobian, touching, sizes_.data(), count_, lever_);
    const double largest = *std::max_element(touch.density.begin(), touch.density.begin() + count_);
    double all = 0, total = 0;
    Wrench mean{}, square{};
    for (int s = 0; s < count_; ++s) {
      const double likely = std::exp(touch.density[s] - largest);
      const double weight = sizes_[s] >= typical_ ? likely : 0.0;
      all += likely;
      total += weight;
      for (int i = 0; i < 6; ++i) {
        mean[i] += weight * touch.mean[s][i];
        square[i] += weight * (touch.variance[s][i] + touch.mean[s][i] * touch.mean[s][i]);
      }
    }
    evidence = largest + std::log(all / count_) - free;
    Wrench wrench{}, std{};
    for (int i = 0; i < 6; ++i) {
      wrench[i] = mean[i] / total;
      std[i] = std::max(square[i] / total - wrench[i] * wrench[i], 0.0);
    }
    // from the place of the contact to the last frame: n + p × F
    const Wrench force = wrench, spread = std;
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      wrench[3 + i] += place[a] * force[b] - place[b] * force[a];
      std[3 + i] += place[a] * place[a] * spread[b] + place[b] * place[b] * spread[a];
    }
    for (int i = 0; i < 6; ++i) std[i] = doubt_ * std::sqrt(std[i]);
    const Wrench& widest = touch.variance[count_ - 1];
    const double most = blind_ * typical_, size = large_ * typical_;
    const bool blind = std::max({widest[0], widest[1], widest[2]}) > most * most;
    const bool large = force[0] * force[0] + force[1] * force[1] + force[2] * force[2] > size * size;
    contact(doubtful || fast, blind, large);
    why_ = answer_.contact != UNKNOWN ? KNOWN : fast ? FAST : doubtful ? STARTED : BLIND;
    if (answer_.contact != SUSPECTED || evidence > freeze_) {
      sure_wrench_ = wrench;
      sure_std_ = std;
    }
    at_flange_ = answer_.contact == CONTACT;
    locate(look(swept, touching, free, doubtful || fast));
    const bool elsewhere = answer_.off_flange >= LIKELY;
    if (elsewhere) why_ = ELSEWHERE;
    answer_.wrench = elsewhere ? Wrench{} : sure_wrench_;
    answer_.std = elsewhere ? unknown_std() : sure_std_;
    limit(jacobian);
  }

  // places on a link, from 0: middles of equal parts of the line between frames; on the last one, of a tool
  int places(int link) const noexcept {
    const double length = link + 1 == n ? TOOL : std::sqrt(dot(tail_[link], tail_[link]));
    return static_cast<int>(std::min(std::ceil(length / SPACING - 1e-9), 1.0 * MAX_PLACES));
  }

  // whether a moving arm is touched before its flange, each LOOK s; returns whether it was looked at
  bool look(const Sweep& swept, const Joints& variance, double free, bool doubtful) noexcept {
    const double never = -std::numeric_limits<double>::infinity();
    if (doubtful || state[0] == STILL || state[0] == SETTLING) {
      odds_ = before_flange = never;
      touched_before_ = false;
      return false;
    }
    if (time_ < look_at_) return false;
    Joints noise{};
    for (int k = 0; k < n; ++k) noise[k] = variance[k] + LOST * torque[k] * (LOST * torque[k]);
    double most = never, sum = 0, share = 0;
    for (int link = 0; link < n; ++link) {
      const int parts = places(link), first = link + 1 == n ? n : link;
      for (int part = 0; part < parts; ++part) {
        const double along = (part + 0.5) / parts;
        const Vector point = (1 - along) * swept.frames[first] + along * swept.frames[first + 1];
        std::array<Wrench, MAX_JOINTS> there{};
        for (int k = 0; k <= link; ++k) {
          const Wrench& own = swept.jacobian[k];
          const Vector lift = cross({own[3], own[4], own[5]}, point);
          there[k] = {own[0] + lift[0], own[1] + lift[1], own[2] + lift[2], own[3], own[4], own[5]};
        }
        const Posterior found = posterior(torque, there, noise, place_size_.data(), PLACE_SIZES, SURFACE, false);
        for (int s = 0; s < PLACE_SIZES; ++s) {
          density_[link][part][s] = found.density[s];
          if (link + 1 == n) continue;
          const double shown = found.density[s] + likely_[link][s];
          sum = shown > most ? sum * std::exp(most - shown) + 1 : sum + std::exp(shown - most);
          most = std::max(most, shown);
          share += std::exp(likely_[link][s]);
        }
      }
    }
    const double odds = most + std::log(sum / share) - free, last = odds_;
    look_at_ = time_ + LOOK;
    odds_ = odds;
    before_flange = std::min(odds, last);
    const bool goes_on = touched_before_ && odds >= threshold_before_ - hysteresis_;
    touched_before_ = before_flange >= threshold_before_ || goes_on;
    return true;
  }

  // which link a contact touches, by the mean of what a few looks at it show
  void locate(bool looked) noexcept {
    answer_.link = 0;
    answer_.off_flange = 0;
    if (touched_before_) {
      answer_.contact = CONTACT;
      why_ = KNOWN;
    }
    if (answer_.contact != CONTACT) {
      if (looks_ > 0) seen_density_ = {};
      looks_ = 0;
      return;
    }
    if (looked) {
      ++looks_;
      for (int k = 0; k < n; ++k)
        for (int p = 0; p < places(k); ++p)
          for (int s = 0; s < PLACE_SIZES; ++s) seen_density_[k][p][s] += density_[k][p][s];
    }
    if (looks_ < LEAST_LOOKS) return;
    double most = -std::numeric_limits<double>::infinity(), all = 0;
    Joints weight{};
    for (int k = 0; k < n; ++k)
      for (int p = 0; p < places(k); ++p)
        for (int s = 0; s < PLACE_SIZES; ++s)
          most = std::max(most, seen_density_[k][p][s] / looks_ + likely_[k][s]);
    for (int k = 0; k < n; ++k) {
      for (int p = 0; p < places(k); ++p)
        for (int s = 0; s < PLACE_SIZES; ++s)
          weight[k] += std::exp(seen_density_[k][p][s] / looks_ + likely_[k][s] - most);
      all += weight[k];
    }
    answer_.off_flange = 1 - weight[n - 1] / all;
    if (answer_.off_flange >= LIKELY) weight[n - 1] = 0;
    answer_.link = 1 + static_cast<int>(std::max_element(weight.begin(), weight.begin() + n) - weight.begin());
  }

  // of a contact that is not stated: the band if nothing has touched, and what could be hidden
  void limit(const std::array<Wrench, MAX_JOINTS>& jacobian) noexcept {
    const bool known = answer_.contact != UNKNOWN, free = known && answer_.contact != CONTACT;
    for (int i = 0; i < 3; ++i) {
      answer_.untouched[i] = NORMAL95 * answer_.std[i];
      answer_.hidden[i] = answer_.hidden_at_all[i] = known ? 0.0 : NORMAL99 * largest_;
    }
    if (!free) return;
    Vector seen{};
    Joints resting{}, since{};
    for (int k = 0; k < n; ++k) {
      const double noise = noise_[state[k]][k] * std::max(std::abs(qd_[k]) / fastest_[k], 1.0);
      const double sticks = still_ ? std::hypot(hidden_[state[k]][k], absorbed_[state[k]][k]) : 0.0;
      const double own = hiding_ * doubt_ * std::hypot(noise, sticks);
      // along one axis, with the torque x = Jᵀ F: 1 / C = 1 / P + Σ (x / κ σ)²
      for (int i = 0; i < 3; ++i) seen[i] += jacobian[k][i] / own * (jacobian[k][i] / own);
      resting[k] = noise_[STILL][k] * noise_[STILL][k];
      since[k] = rest_[k] - settled_[k];
    }
    Posterior now, ever;  // of the typical force alone, and of a slow press
    if (still_) {
      const double sizes[] = {typical_, press_ * typical_};
      now = posterior(since, jacobian, resting, sizes, 2, lever_);
      ever = posterior(rest_, jacobian, resting, sizes + 1, 1, lever_);
    }
    for (int i = 0; i < 3; ++i) {
      const double missed = 1 / std::sqrt(1 / (typical_ * typical_) + seen[i]);
      answer_.hidden[i] = NORMAL99 * std::hypot(missed, doubt_ * now.mean[1][i]);
      answer_.hidden_at_all[i] = NORMAL99 * std::hypot(missed, doubt_ * ever.mean[0][i]);
      if (still_)
        answer_.untouched[i] = std::min(answer_.untouched[i], NORMAL95 * doubt_ * std::sqrt(now.variance[0][i]));
    }
  }

  // moments: whether the wrench is wanted, too, beside the density
  Posterior posterior(const Joints& sensed, const std::array<Wrench, MAX_JOINTS>& jacobian, const Joints& variance,
                      const double* sizes, int count, double lever, bool moments = true) const noexcept {
    Square told{};  // its lower triangle, as of all symmetric ones here
    Wrench seen{};
    double alone = 0;
    for (int k = 0; k < n; ++k) {
      alone += sensed[k] * sensed[k] / variance[k] + std::log(variance[k]);
      for (int i = 0; i < 6; ++i) {
        const double weighted = jacobian[k][i] / variance[k];
        seen[i] += weighted * sensed[k];
        for (int j = 0; j <= i; ++j) told[i][j] += weighted * jacobian[k][j];
      }
    }
    Posterior result;
    for (int s = 0; s < count; ++s) {
      Square factor = told;  // L of L Lᵀ = P⁻¹ + Λ
      Wrench inverted{}, whitened{};  // 1 / L_jj, and L⁻¹ Jᵀ S⁻¹ τ
      double misfit = alone, volume = 1;
      for (int i = 0; i < 6; ++i) {
        const double size = (i < 3 ? 1.0 : lever) * sizes[s];
        factor[i][i] += 1 / (size * size);
        volume *= size;
      }
      for (int j = 0; j < 6; ++j) {
        for (int m = 0; m < j; ++m) factor[j][j] -= factor[j][m] * factor[j][m];
        factor[j][j] = std::sqrt(factor[j][j]);
        inverted[j] = 1 / factor[j][j];
        volume *= factor[j][j];
        for (int i = j + 1; i < 6; ++i) {
          for (int m = 0; m < j; ++m) factor[i][j] -= factor[i][m] * factor[j][m];
          factor[i][j] *= inverted[j];
        }
      }
      for (int i = 0; i < 6; ++i) {
        whitened[i] = seen[i];
        for (int j = 0; j < i; ++j) whitened[i] -= factor[i][j] * whitened[j];
        whitened[i] *= inverted[i];
        misfit -= whitened[i] * whitened[i];
      }
      result.density[s] = -(misfit + 2 * std::log(volume)) / 2;
      if (!moments) continue;
      // the inverse of L; the covariance is its square
      Square inverse{};
      for (int j = 0; j < 6; ++j)
        for (int i = j; i < 6; ++i) {
          double sum = i == j;
          for (int m = j; m < i; ++m) sum -= factor[i][m] * inverse[m][j];
          inverse[i][j] = sum * inverted[i];
        }
      for (int i = 0; i < 6; ++i)
        for (int m = i; m < 6; ++m) {
          result.mean[s][i] += inverse[m][i] * whitened[m];
          result.variance[s][i] += inverse[m][i] * inverse[m][i];
        }
    }
    return result;
  }

  void contact(bool doubtful, bool blind, bool large) noexcept {
    if (evidence < threshold_) below_at_ = time_;
    if (evidence >= threshold_ - hysteresis_) above_at_ = time_;
    if (touched_)
      touched_ = time_ - above_at_ <= release_;
    else
      touched_ = !doubtful && time_ - below_at_ >= (stops() ? stopping_ : duration_);
    const bool felt = feels();
    const bool touching = touched_ || (felt && !doubtful);
    const bool suspected = evidence > freeze_ || large;
    const bool unknown = doubtful || (still_ && blind);
    answer_.contact = touching ? CONTACT : unknown ? UNKNOWN : suspected ? SUSPECTED : FREE;
  }

  // whether a joint is much slower than its mean speed until now
  bool stops() const noexcept {
    for (int k = 0; k < n; ++k)
      if (speed_[k] > rest_speed_ && std::abs(qd_[k]) < slows_ * speed_[k]) return true;
    return false;
  }

  // whether encoders of a resting arm feel a contact: from a first push until its joints stay
  bool feels() noexcept {
    const double share = passed_ / (window_ + passed_);
    bool moved = false, pushed = false;
    for (int k = 0; k < n; ++k) {
      pull_[k] += share * ((state[k] == STILL ? torque[k] : 0.0) - pull_[k]);
      const double shift = q_[k] - anchor_[k];
      if (std::abs(shift) > shift_) {
        moved = true;
        pushed = pushed || -pull_[k] * sign(shift) < breakaway_[k];
      }
    }
    if (!still_) {
      felt_at_ = std::numeric_limits<double>::infinity();
      moved_at_ = time_;
    } else if (moved) {
      if (pushed && time_ - moved_at_ > stays_) felt_at_ = std::min(felt_at_, time_);
      moved_at_ = time_;
    } else if (time_ - moved_at_ > stays_) {
      felt_at_ = std::numeric_limits<double>::infinity();
    }
    return time_ - felt_at_ >= confirmed_;
  }

  void learn() noexcept {
    if (at_flange_ || evidence > freeze_) suspected_at_ = time_;
    if (time_ - suspected_at_ < thaw_) return;
    const double share = passed_ / slow_;
    for (int k = 0; k < n; ++k) {
      if (state[k] == MOVING) {
        const double error = share * torque[k];
        drift_[k] += error;
        scale_[k] += error * friction_[k] / (friction_[k] * friction_[k] + breakaway_[k] * breakaway_[k]);
      }
    }
    if (!at_rest_) return;
    rested_ += passed_;
    const double own = rested_ <= settle_ ? passed_ / rested_ : share;
    for (int k = 0; k < n; ++k) rest_[k] += own * (observed[k] - rest_[k]);
    if (rested_ <= settle_) settled_ = rest_;
  }

  std::array<Matrix, MAX_JOINTS> turn_{}, inertia_{};
  std::array<Vector, MAX_JOINTS> tail_{}, center_{};
  Vector gravity_{};
  std::array<std::string, KINDS> misfits_;
  int stated_ = 0, own_ = 0, refused_ = -1, why_ = UNUSABLE;
  Efforts efforts_;
  Joints motor_{}, mass_{}, rotor_{}, constant_{}, offset_{}, breakaway_{}, fastest_{}, strongest_{};
  std::array<Joints, TERMS> terms_{};
  bool stribeck_ = false;  // whether there are such terms, which cost three powers for each joint
  std::array<Joints, STATE_COUNT> noise_{}, hidden_{}, absorbed_{};
  std::array<double, MAX_PARTS> distance_{}, share_{};
  std::array<Joints, MAX_PARTS> held_{};
  std::array<double, MAX_SIZES> sizes_{};
  Vector place_{};
  int parts_ = 0, count_ = 0;
  std::array<double, PLACE_SIZES> place_size_{};
  std::array<std::array<double, PLACE_SIZES>, MAX_JOINTS> likely_{};
  double threshold_, threshold_before_, period_, max_gap_, turns_, margin_, jump_, gain_, acceleration_, encoder_;
  double dead_zone_, rest_speed_, stop_, settle_, reversal_, wide_, doubt_, rare_, lever_, quiet_, typical_;
  double duration_, hysteresis_, freeze_, thaw_, slow_, shift_, window_, confirmed_, stays_;
  double large_, blind_, faster_, least_step_, moved_, slows_, stopping_, release_, hiding_, press_, largest_;
  // of the run
  double time_ = 0, passed_, rested_, started_, below_at_, above_at_, suspected_at_, moved_at_, felt_at_;
  Joints q_{}, qd_{}, lag_{}, momentum_{}, rate_{}, friction_{}, drift_{}, scale_{}, rest_{}, settled_{};
  Joints fast_at_{}, slow_at_{}, anchor_{}, pull_{}, low_{}, high_{}, speed_{}, last_q_{}, last_current_{};
  std::array<Joints, MAX_PARTS> direction_{};
  bool runs_ = false, touched_ = false, at_rest_ = false, still_ = false, seen_ = false;
  bool touched_before_ = false, at_flange_ = false;
  double odds_, look_at_;
  int looks_ = 0;
  Densities density_{}, seen_density_{};
  Wrench sure_wrench_{}, sure_std_{};
  int missed_ = 0;
  Answer answer_;
};

}  // namespace live
