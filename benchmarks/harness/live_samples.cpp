// Answers of live.hpp to samples: `live_samples arm.json` reads lines of time, q, qd, current from
// standard input (qd: "none" where there is none), and prints wrench, std, limits, torques, states, contact, evidence, link.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <new>
#include <vector>

#include "live.hpp"

static bool counting = false;
static long allocations = 0;
void* operator new(std::size_t size) {
  if (counting) ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

int main(int, char** arguments) {
  live::Live arm = live::Live::load(arguments[1]);
  const int n = arm.n;
  std::vector<double> row(1 + 3 * n);
  std::vector<double> took;
  took.reserve(10000000);
  std::string word;
  while (std::cin >> word) {
    bool stated = true;
    row[0] = std::strtod(word.c_str(), nullptr);
    for (int i = 1; i < 1 + 3 * n && std::cin >> word; ++i) {
      stated = stated && word != "none";
      row[i] = std::strtod(word.c_str(), nullptr);
    }
    const auto start = std::chrono::steady_clock::now();
    counting = true;
    const live::Answer& now = arm.step(row[0], &row[1], stated ? &row[1 + n] : nullptr, &row[1 + 2 * n]);
    counting = false;
    took.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    for (double value : now.wrench) std::printf("%.17g ", value);
    for (double value : now.std) std::printf("%.17g ", value);
    for (const live::Vector& limit : {now.untouched, now.hidden, now.hidden_at_all})
      for (double value : limit) std::printf("%.17g ", value);
    for (int k = 0; k < n; ++k) std::printf("%.17g %d ", arm.torque[k], arm.state[k]);
    std::printf("%d %.17g %d %.17g\n", now.contact, arm.evidence, now.link, now.off_flange);
  }
  std::sort(took.begin(), took.end());
  std::fprintf(stderr, "%ld allocations, median %.3f us, 99th percentile %.3f us\nreason: %s\n", allocations,
               took[took.size() / 2], took[took.size() * 99 / 100], arm.reason());
}
