# A study of many recordings: in place of the rules above that run for each recording, a rule for each
# level of a batch of them (ur5lib/steps/batches.py). Scripts, settings and results are the same.
import csv


def declared(step):
    """Return a step as its rule declares it."""
    of = {"recording": frozenset(recordings_of(step.name)), "robot": frozenset(ROBOTS)}
    wildcard = next(iter(step.wildcard_names), "")
    kinds = (dict(kind.items()) for kind in (step.input, step.output, step.params, step.log))
    return Step(step.name, wildcard, of.get(wildcard, frozenset()), *map(unconstrained, kinds))


def unconstrained(value):
    """Return what a rule declares without the constraints that Snakemake adds to wildcards."""
    if isinstance(value, dict):
        return {name: unconstrained(item) for name, item in value.items()}
    if isinstance(value, str):
        return CONSTRAINT.sub(r"{\1}", value)
    return [*map(unconstrained, value)] if isinstance(value, list | tuple) else value


def writes_in(folder, step):
    return str(step.output[0]).startswith(f"{RESULTS}/{folder}")


def needs_of(level):
    """Return a function of what a batch reads at a level."""
    return lambda wildcards: BATCHES.needs(level, wildcards.batch)


def settings_of(level):
    """Return a function of a checksum of a batch's settings at a level."""
    return lambda wildcards: BATCHES.settings(level, wildcards.batch)


def wait_for_stamps(reader):
    """Let a rule wait for the stamps of batches, and give its script the files themselves."""
    step = declared(reader)
    reader._input = type(reader.input)()
    reader.set_input(lambda wildcards: BATCHES.stamped(step.files("input", *wildcards)))
    reader.set_params(
        files=lambda wildcards: step.filled("input", *wildcards),
        is_kept=bool(step.wildcard) and not step.name.endswith("_for_paper"),
    )


def in_cluster_at(group, level):
    """Return the group of the steps of a level; `--group-components` holds for each of them."""
    workflow.parent_groupids[f"{group}_{level}"] = group
    return in_cluster(f"{group}_{level}")


def list_left_out():
    """Print what was left out and why, and write it as a table."""
    absent = BATCHES.left_out() if BATCHES else {}
    table = Path(f"{RESULTS}/tables/left_out.csv")
    if absent:
        reasons = (f"  {name}: {reason}" for name, reason in absent.items())
        print(f"{len(absent)} of {len(RECORDINGS)} recordings were left out:", *reasons, sep="\n")
        table.parent.mkdir(exist_ok=True)
        with open(table, "w", newline="") as file:
            csv.writer(file).writerows([("recording", "reason"), *absent.items()])
    else:
        table.unlink(missing_ok=True)


if len(RECORDINGS) > MOST_ALONE or BY_PATTERN & RECORDINGS.keys():
    steps = [step for step in workflow.rules if "code" in step.params.keys()]
    each = [step for step in steps if writes_in("recordings/{recording", step)]
    arms = [step for step in steps if writes_in("parameters/{robot", step)]
    one_of_each_kind = {(one.arm.known_as, one.role): name for name, one in RECORDINGS.items()}
    BATCHES = Batches(
        RESULTS,
        {step.name: declared(step) for step in each},
        {step.name: declared(step) for step in arms},
        [*one_of_each_kind.values()],
        sorted(RECORDINGS, key=lambda name: RECORDINGS[name].arm.known_as),
    )
    if workflow.is_main_process:
        BATCHES.forget_incomplete()
    for step in steps:
        if step in each:
            del workflow._rules[step.name]
        elif not step.name.startswith("simulate_recording"):
            if step not in arms:
                step.group = in_cluster("document")
            elif step.name not in workflow._localrules:
                step.group = in_cluster_at("fits", BATCHES.level_of_arm(step.name))
            wait_for_stamps(step)
    for level in range(len(BATCHES.levels)):

        rule:
            name:
                f"process_batch_{level}"
            input:
                needs_of(level),
            output:
                BATCHES.stamp(level, "{batch}"),
            log:
                f"{RESULTS}/logs/process_batch_{level}/{{batch}}.log",
            group:
                in_cluster_at("batches", level)
            params:
                level=level,
                settings=settings_of(level),
            run:
                chains = BATCHES.chains(params.level, wildcards.batch)
                optional = BY_PATTERN if params.level == 0 else ()
                run_batch(chains, input, output[0], log[0], optional)
