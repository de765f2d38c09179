//! Bad input and faults of the design, one by one: what happens, and the test that holds it.

/// A line of the table.
pub struct Fault {
    pub fault: &'static str,
    pub happens: &'static str,
    /// Files with the names of tests in them.
    pub held: &'static [(&'static str, &'static str)],
}

const INPUT: &str = "tests/bad_input.rs";
const RUNS: &str = "tests/runs/faults.rs";
const RESUME: &str = "tests/runs/resume.rs";
const VOLUMES: &str = "tests/voxel_universe/files.rs";

pub const FAULTS: &[Fault] = &[
    Fault {
        fault: "unknown element or attribute, duplicate id, missing reference",
        happens: "file, line, column, the text underlined, the nearest name; exit 2",
        held: &[(INPUT, "fn names"), (INPUT, "fn one_message_whole"), (INPUT, "fn what_belongs_together")],
    },
    Fault {
        fault: "missing or wrong unit, value out of range, nan, inf, 1e999",
        happens: "the same, with the units known or the range allowed",
        held: &[
            (INPUT, "fn numbers"),
            ("tests/command_line.rs", "fn bad_input_exits_with_2_and_shows_the_place"),
        ],
    },
    Fault {
        fault: "several errors in one file",
        happens: "all told in one go",
        held: &[(INPUT, "fn all_errors_at_once")],
    },
    Fault {
        fault: "truncated XML, two roots, no root, trailing text, NUL, undefined entity, DOCTYPE, nesting > 64, file > 64 MiB",
        happens: "refused, with place",
        held: &[(INPUT, "fn xml_itself")],
    },
    Fault {
        fault: "any damage to a shipped file",
        happens: "an error or a sound scene: no panic, nothing over 2 s, no memory beyond its budget",
        held: &[
            (INPUT, "fn mutations_never_panic"),
            ("tests/mutations.rs", "fn scenes"),
            ("tests/mutations.rs", "fn volumes"),
        ],
    },
    Fault {
        fault: "path out of the scene's folder",
        happens: "refused unless `--allow-outside`; the message names the resolved path",
        held: &[(INPUT, "fn files"), (INPUT, "fn a_path_out_is_allowed_by_the_option_only")],
    },
    Fault {
        fault: "wavelength outside a table",
        happens: "error with table and range; `extrapolate=\"clamp\"` is a remark of the plan and of manifest.json",
        held: &[(INPUT, "fn wavelengths_outside_a_table")],
    },
    Fault {
        fault: "voxel file without voxel size, label without material",
        happens: "refused, with place",
        held: &[(VOLUMES, "fn scenes_with_bad_volumes_are_refused")],
    },
    Fault {
        fault: "header of a volume larger than its data or than the memory budget",
        happens: "refused before anything is allocated",
        held: &[(VOLUMES, "fn bad_files_are_refused_with_reasons")],
    },
    Fault {
        fault: "overlapping components",
        happens: "the rule is stated; `check --structure` samples and tells pairs, coordinates and shares",
        held: &[("tests/realise.rs", "fn the_structure_is_told_and_drawn")],
    },
    Fault {
        fault: "lost ray",
        happens: "its power stands in the ledger, its history on record for `replay`; beyond max(10, 1e-6 N) the run fails",
        held: &[
            ("src/run/health.rs", "fn lost_rays_and_open_ledgers_fail_beyond_their_ceilings"),
            ("tests/runs/replay.rs", "fn replayed_histories_add_up_to_the_run"),
        ],
    },
    Fault {
        fault: "event cap",
        happens: "what is cut stands in the ledger as truncated, with a record",
        held: &[("tests/hard_cases/relations.rs", "fn the_event_cap_books_what_it_cuts")],
    },
    Fault {
        fault: "Ctrl-C, SIGTERM",
        happens: "the batch is finished, checkpoint and partial results marked incomplete are written; exit 130 or 143",
        held: &[
            (RESUME, "fn a_stopped_run_is_a_prefix_and_resumes"),
            (RESUME, "fn stopped_at_100_random_moments"),
        ],
    },
    Fault {
        fault: "a second signal",
        happens: "stops at once",
        held: &[(RESUME, "fn a_second_signal_stops_at_once")],
    },
    Fault {
        fault: "kill −9, power loss",
        happens: "the last checkpoint is whole; `resume` gives the bytes of a run that nothing stopped",
        held: &[
            (RESUME, "fn a_killed_run_resumes_to_the_same_bytes"),
            (RESUME, "fn killed_at_100_random_moments"),
        ],
    },
    Fault {
        fault: "damaged checkpoint, changed scene",
        happens: "refused by checksum, by name",
        held: &[
            (RUNS, "fn a_damaged_checkpoint_is_refused"),
            (RUNS, "fn impossible_counters_are_refused"),
            (RUNS, "fn a_used_folder_names_resume_and_a_changed_scene_is_refused"),
        ],
    },
    Fault {
        fault: "disk full",
        happens: "message, exit not zero, old files as they were",
        held: &[(RUNS, "fn a_full_disk_is_told_and_leaves_the_old_files")],
    },
    Fault {
        fault: "closed pipe",
        happens: "the same",
        held: &[(RUNS, "fn a_closed_pipe_is_told_and_nothing_is_touched")],
    },
    Fault {
        fault: "unwritable folder",
        happens: "told before the run",
        held: &[("tests/command_line.rs", "fn an_unwritable_folder_is_told_before_the_run")],
    },
    Fault {
        fault: "too little memory",
        happens: "the estimate stands in the plan; over the limit the run is refused before it begins",
        held: &[(RUNS, "fn too_little_memory_is_refused_before_the_run")],
    },
    Fault {
        fault: "panic in a worker",
        happens: "caught in its batch, told with its history, no sums of it kept; exit 70",
        held: &[
            ("src/run/workers.rs", "fn a_panic_in_a_worker_is_caught_with_its_history"),
            ("tests/hard_cases/faults.rs", "fn exit_codes"),
        ],
    },
];

#[test]
fn exit_codes() {
    use lightpro::command::Failure;
    let text = String::new;
    let codes =
        [Failure::Physics(text()), Failure::Input(text()), Failure::Internal(text())].map(|f| f.code());
    assert_eq!(codes, [1, 2, 70]);
    assert_eq!([2, 15].map(|signal| Failure::Stopped(signal, text()).code()), [130, 143]);
}
