#include "daemon/command_line.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "daemon/commands.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

namespace {

constexpr const char* about =
    "shakerd drives a shaker with gamma [rho sin wt + (1-rho) sin(2wt + phi)], measures what the base and the walker\n"
    "on it do, and says the walker's drift v_D while the experiment runs.\n";

constexpr const char* ending =
    "\nQuantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz; a bare number is SI.\n"
    "Exit status: 0 done; 1 failure; 2 input refused, nothing written; 3 device or disk failed;\n"
    "4 replay is not identical.\n";

// The drive's words as typed, read after parsing so that errors name option, value and range.
struct DriveWords {
    std::string gamma = "1g", phi = "0deg", rho = "0.5", frequency = "20Hz";

    void add_to(CLI::App& app) {
        app.add_option("--gamma", gamma, "Acceleration amplitude of the base, e.g. 1.5g or 14.7m/s^2")->capture_default_str();
        app.add_option("--phi", phi, "Phase of the second harmonic, e.g. 35deg or 0.61rad")->capture_default_str();
        app.add_option("--rho", rho, "Share of the first harmonic, 0 to 1")->capture_default_str();
        app.add_option("--frequency", frequency, "Drive frequency, e.g. 20Hz")->capture_default_str();
    }
    [[nodiscard]] Drive read() const {
        return {.frequency = parse_quantity("--frequency", frequency, Dimension::frequency, {1, 1000}),
                .gamma = parse_quantity("--gamma", gamma, Dimension::acceleration, {0, 100 * paper_g}),
                .rho = parse_quantity("--rho", rho, Dimension::ratio, {0, 1}),
                .phi = parse_quantity("--phi", phi, Dimension::angle, {-2 * two_pi, 2 * two_pi})};
    }
};

void add_json(CLI::App& app, bool& json) {
    app.add_flag("--json", json, "Print one JSON object, SI units in the key names");
}

}  // namespace

int command_line(int argc, char** argv) {
    CLI::App app{about, "shakerd"};
    app.footer(ending);
    app.require_subcommand(1);
    app.set_version_flag("--version", "shakerd " SHAKER_VERSION);
    app.get_formatter()->column_width(34);

    RunOptions run_options;
    DriveWords run_drive;
    bool no_frames = false;
    CLI::App& run_app = *app.add_subcommand("run", "Drive a rig, measure, track, reduce and record");
    run_app.add_option("--rig", run_options.rig, "Which rig: sim: is the simulated bench")->capture_default_str();
    run_app.add_option("--scene", run_options.scene, "TOML file that changes the simulated bench (see README)");
    run_drive.add_to(run_app);
    run_app.add_option("--periods", run_options.periods, "Drive periods to measure, after drive and walker have settled")
        ->capture_default_str()
        ->check(CLI::Range(2, 1'000'000));
    run_app.add_option("-o,--output", run_options.out, "Recording (HDF5); without it nothing is kept");
    run_app.add_flag("--no-frames", no_frames, "Record tracks and counts but not the pictures");
    run_app.add_flag("--threads", run_options.threads, "One thread a loop as on hardware, instead of lockstep");
    add_json(run_app, run_options.json);
    run_app.footer("Example: shakerd run --rig sim: --gamma 1.5g --phi 35deg --periods 40 -o run.nxs");

    ReplayOptions replay_options;
    CLI::App& replay_app = *app.add_subcommand("replay", "Recompute a recording's results from its raw streams");
    replay_app.add_option("file", replay_options.file, "Recording")->required();
    add_json(replay_app, replay_options.json);
    replay_app.footer("Exit status 4 when any number differs in any bit from the recorded one.");

    ReduceOptions reduce_options;
    bool reduce_no_frames = false;
    CLI::App& reduce_app = *app.add_subcommand("reduce", "Reduce a session that shakerd did not record");
    reduce_app.add_option("session", reduce_options.session, "session.toml: movies, accelerations, geometry")->required();
    reduce_app.add_option("-o,--output", reduce_options.out, "Recording (HDF5) that replays");
    reduce_app.add_flag("--no-frames", reduce_no_frames, "Do not copy the pictures into the recording");
    add_json(reduce_app, reduce_options.json);

    TrackOptions track_options;
    CLI::App& track_app = *app.add_subcommand("track", "Track the targets of a session, without reducing it");
    track_app.add_option("session", track_options.session, "session.toml; drive and accelerometer are not needed")->required();
    track_app.add_option("-o,--output", track_options.out, "CSV: camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state");
    add_json(track_app, track_options.json);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? exit_ok : exit_input;
    }
    if (run_app.parsed()) {
        run_options.drive = run_drive.read();
        run_options.keep_frames = !no_frames;
        run(run_options);
    }
    if (replay_app.parsed() && !replay(replay_options)) return exit_not_identical;
    if (reduce_app.parsed()) {
        reduce_options.keep_frames = !reduce_no_frames;
        reduce_session(reduce_options);
    }
    if (track_app.parsed()) track_session(track_options);
    return exit_ok;
}

}  // namespace shaker
