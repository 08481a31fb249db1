#include "daemon/command_line.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "daemon/commands.hpp"
#include "daemon/confined.hpp"
#include "daemon/exit_status.hpp"
#include "daemon/manual_command.hpp"
#include "daemon/predict.hpp"
#include "daemon/run_settings.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

namespace {

constexpr const char* about =
    "shakerd drives a shaker with gamma [rho sin wt + (1-rho) sin(2wt + phi)], measures what the base and "
    "the walker\n"
    "on it do, and says the walker's drift v_D while the experiment runs.\n";

constexpr int most_port = 65535;

constexpr const char* rig_help = "A rig file (TOML) that names the devices, or sim: for the simulated bench";

std::string ending() {
    std::string text =
        "\nQuantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz; a bare number is SI.\nExit "
        "status:\n";
    for (const ExitMeaning& s : exit_meanings)
        text += "  " + std::to_string(s.number) + "  " + s.meaning + "\n";
    return text;
}

// The drive's words as typed, read after parsing so that errors name option, value and range.
struct DriveWords {
    std::string gamma, phi, rho, frequency;

    void add_to(CLI::App& app) {
        app.add_option("--gamma", gamma, "Acceleration amplitude of the base, e.g. 1.5g or 14.7m/s^2 [1g]");
        app.add_option("--phi", phi, "Phase of the second harmonic, e.g. 35deg or 0.61rad [0]");
        app.add_option("--rho", rho, "Share of the first harmonic, 0 to 1 [0.5]");
        app.add_option("--frequency", frequency, "Drive frequency, e.g. 20Hz [20Hz]");
    }
    /// `drive` with what was typed.
    [[nodiscard]] Drive over(Drive drive) const {
        const auto set = [](const char* option, const std::string& text, Dimension dimension, Range range,
                            double& x) {
            if (!text.empty()) x = parse_quantity(option, text, dimension, range);
        };
        set("--frequency", frequency, Dimension::frequency, drive_limits.frequency, drive.frequency);
        set("--gamma", gamma, Dimension::acceleration, drive_limits.gamma, drive.gamma);
        set("--rho", rho, Dimension::ratio, drive_limits.rho, drive.rho);
        set("--phi", phi, Dimension::angle, drive_limits.phi, drive.phi);
        return drive;
    }
};

// What predict takes besides the drive.
struct PredictWords {
    std::string mu = "0.113", mu_s, viscous = "0", tilt = "0deg", start = "0mm/s";
    std::string cases;
    CLI::Option* json = nullptr;

    void add_to(CLI::App& app) {
        app.add_option("--mu", mu, "Kinetic friction coefficient")->capture_default_str();
        app.add_option("--mu-s", mu_s, "Static friction coefficient, at least --mu [default: --mu]");
        app.add_option("--viscous", viscous, "Velocity strengthening c, 1/s")->capture_default_str();
        app.add_option("--tilt", tilt, "Downhill towards +x, e.g. 0.1deg")->capture_default_str();
        app.add_option("--start", start,
                       "Walker's velocity at phase 0, e.g. 20mm/s: with --mu-s above --mu the\n"
                       "settled motion may depend on it")
            ->capture_default_str();
        json = app.add_option("--json", cases,
                              "Print JSON; with a file, the cases in it (tests/golden/\n"
                              "physics_reference.json shows the format)")
                   ->expected(0, 1);
        app.footer("Example: shakerd predict --gamma 1.5g --phi 35deg --mu 0.113");
    }
    void print(const Drive& drive) const {
        if (!cases.empty()) {
            std::cout << predict_cases(cases);
            return;
        }
        PredictOptions o{.drive = drive};
        o.friction.mu_k = parse_quantity("--mu", mu, Dimension::ratio, {0, 100});
        o.friction.mu_s = mu_s.empty()
                              ? o.friction.mu_k
                              : parse_quantity("--mu-s", mu_s, Dimension::ratio, {o.friction.mu_k, 100});
        o.friction.viscous = parse_quantity("--viscous", viscous, Dimension::ratio, {0, 1e4});
        o.tilt = parse_quantity("--tilt", tilt, Dimension::angle, {-1.5, 1.5});
        o.v_start = parse_quantity("--start", start, Dimension::velocity, {-100, 100});
        o.json = json->count() > 0;
        std::cout << predict(o);
    }
};

void add_frames(CLI::App& app, std::string& word) {
    app.add_option("--frames", word,
                   "Pictures to record: off, region (the part targets can be in) or full [region];\n"
                   "of a run that a limit stopped the last 2 s are kept always")
        ->check(CLI::IsMember({"off", "region", "full"}));
}

void set_frames(KeptPictures& pictures, const std::string& word) {
    if (const auto kept = kept_pictures_named(word)) pictures = *kept;
}

void add_json(CLI::App& app, bool& json) {
    app.add_flag("--json", json, "Print one JSON object, SI units in the key names");
}

}  // namespace

int command_line(int argc, char** argv, const std::function<void(const ServeOptions&)>& serve) {
    CLI::App app{about, "shakerd"};
    app.footer(ending());
    app.require_subcommand(1);
    app.set_version_flag("--version", "shakerd " SHAKER_VERSION);
    app.get_formatter()->column_width(34);

    RunOptions run_options;
    DriveWords run_drive;
    std::filesystem::path settings, scene;
    int periods = 0, settle = -1;
    std::string run_frames;
    bool no_identify = false, open_loop = false;
    CLI::App& run_app = *app.add_subcommand("run", "Drive a rig, measure, track, reduce and record");
    run_app.add_option("--rig", run_options.rig, rig_help)->capture_default_str();
    run_app.add_option("--scene", scene, "TOML file that changes the simulated bench (see README)");
    run_app.add_option("--settings", settings,
                       "TOML file with a table [run]; options on the command line win");
    run_drive.add_to(run_app);
    run_app.add_option("--periods", periods, "Drive periods to measure once all has settled [40]")
        ->check(CLI::Range(2, most_periods));
    run_app
        .add_option("--settle", settle,
                    "Drive periods of the settled drive before those; 0: until the walker is steady [0]")
        ->check(CLI::Range(0, most_settle_periods));
    run_app.add_option("-o,--output", run_options.out, "Recording (HDF5); without it only trips are kept");
    run_app
        .add_option("--trips", run_options.trips,
                    "Folder for trip-<UTC>.nxs, the last 2 s of a run that a limit stopped and that\n"
                    "has no --output")
        ->capture_default_str()
        ->check(CLI::ExistingDirectory);
    add_frames(run_app, run_frames);
    run_app.add_flag("--no-identify", no_identify,
                     "Take the data sheet's response instead of finding it out before the run");
    run_app.add_flag("--open-loop", open_loop, "Do not correct the drive by what was measured");
    run_app.add_flag("--threads", run_options.threads,
                     "One thread a loop, as on hardware, instead of lockstep");
    run_app.add_flag("--real-time", run_options.real_time,
                     "With --threads: a simulated rig takes the time that a real one takes");
    add_json(run_app, run_options.json);
    run_app.footer("Example: shakerd run --rig sim: --gamma 1.5g --phi 35deg --periods 40 -o run.nxs");

    ServeOptions serve_options;
    CLI::App& serve_app =
        *app.add_subcommand("serve", "The daemon: a bench on call, with its page and remote control");
    serve_app
        .add_option("--settings", serve_options.settings,
                    "TOML file with the tables [serve] and [run] (see README)")
        ->check(CLI::ExistingFile);
    serve_app.add_option("--rig", serve_options.rig, rig_help);
    serve_app.add_option("--scene", serve_options.scene,
                         "TOML file that changes the simulated bench (see README)");
    serve_app
        .add_option("--http-port", serve_options.http_port,
                    "Of page, metrics and streams; 0: any that is free [8080]")
        ->check(CLI::Range(0, most_port));
    serve_app
        .add_option("--scpi-port", serve_options.scpi_port,
                    "Of the instrument language; 0: any that is free [5025]")
        ->check(CLI::Range(0, most_port));
    serve_app.add_option("--page", serve_options.page, "Folder of the page's files")
        ->check(CLI::ExistingDirectory);
    serve_app.add_option("--recordings", serve_options.recordings, "Folder of recordings [.]")
        ->check(CLI::ExistingDirectory);
    serve_app.footer("Example: shakerd serve --rig sim: --page build/panel");

    CheckOptions check_options;
    CLI::App& check_app = *app.add_subcommand("check", "Open every device of a rig and test it at low level");
    check_app.add_option("--rig", check_options.rig, rig_help)->capture_default_str();
    check_app.add_option("--scene", check_options.scene, "TOML file that changes the simulated bench");
    check_app.add_option("--frequency", check_options.frequency_hz, "Hz, of the first of two harmonics")
        ->capture_default_str()
        ->check(CLI::Range(drive_limits.frequency.min, drive_limits.frequency.max));
    check_app.add_option("--level", check_options.level, "Of the DAC's full scale, each harmonic")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 0.2));
    add_json(check_app, check_options.json);
    check_app.footer("Exit status 3 when a device is not fit to run.");

    DevicesOptions devices_options;
    CLI::App& devices_app = *app.add_subcommand("devices", "List what is connected and what it can do");
    devices_app.add_option("--iio", devices_options.iio,
                           "Look for accelerometers there too, e.g. ip:192.168.1.7");
    devices_app.add_option("--pcm", devices_options.pcm, "This PCM instead of the sound cards' own");
    devices_app.add_option("--alsa-config", devices_options.alsa_config, "File that defines it")
        ->check(CLI::ExistingFile);
    add_json(devices_app, devices_options.json);

    ReplayOptions replay_options;
    CLI::App& replay_app =
        *app.add_subcommand("replay", "Recompute a recording's results from its raw streams");
    replay_app.add_option("file", replay_options.file, "Recording")->required();
    std::string from = "best", speed = "max";
    replay_app
        .add_option("--from", from,
                    "raw: from the pictures; tracks: from the stored positions;\n"
                    "best: raw where every picture was kept")
        ->capture_default_str()
        ->check(CLI::IsMember({"best", "raw", "tracks"}));
    replay_app.add_option("--speed", speed, "max, or real: as slowly as it was recorded")
        ->capture_default_str()
        ->check(CLI::IsMember({"max", "real"}));
    replay_app.add_option("--set", replay_options.set,
                          "key=value: reduce with this instead of what was recorded, and say what\n"
                          "changes, e.g. top.mm_per_px=0.1 or from_s=3.5 (an unknown key lists all)");
    add_json(replay_app, replay_options.json);
    replay_app.footer("Exit status 4 when any number differs in any bit from the recorded one.");

    RecoverOptions recover_options;
    CLI::App& recover_app =
        *app.add_subcommand("recover", "Finish what a crash left of a recording, or verify a finished one");
    recover_app.add_option("file", recover_options.file, "Recording, or its .part")->required();
    add_json(recover_app, recover_options.json);
    recover_app.footer(
        "The .part stays as it is. Exit status 4 when a finished file is not what was written.");

    ExportOptions export_options;
    std::string format = "csv";
    CLI::App& export_app = *app.add_subcommand("export", "Write a recording's tables as CSV or MAT files");
    export_app.add_option("file", export_options.file, "Recording")->required();
    export_app.add_option("-o,--output", export_options.folder,
                          "Folder, made if need be [FILE.export, FILE without its ending]");
    export_app.add_option("--format", format, "csv: a file a table; mat: one file, a struct a table")
        ->capture_default_str()
        ->check(CLI::IsMember({"csv", "mat"}));
    export_app
        .add_option("--what", export_options.what,
                    "tracks,accelerometer,results,periods,cycle,... or all, which leaves out drive, every\n"
                    "sample of it (an unknown word lists what there is)")
        ->delimiter(',')
        ->capture_default_str();
    add_json(export_app, export_options.json);
    export_app.footer("Example: shakerd export run.nxs --what tracks,drive. Nothing is written over.");

    ReduceOptions reduce_options;
    std::string reduce_frames;
    CLI::App& reduce_app = *app.add_subcommand("reduce", "Reduce a session that shakerd did not record");
    reduce_app.add_option("session", reduce_options.session, "session.toml: movies, accelerations, geometry")
        ->required();
    reduce_app.add_option("-o,--output", reduce_options.out, "Recording (HDF5) that replays");
    add_frames(reduce_app, reduce_frames);
    add_json(reduce_app, reduce_options.json);

    TrackOptions track_options;
    CLI::App& track_app = *app.add_subcommand("track", "Track the targets of a session, without reducing it");
    track_app
        .add_option("session", track_options.session, "session.toml; drive and accelerometer are not needed")
        ->required();
    track_app.add_option("-o,--output", track_options.out,
                         "CSV: camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state");
    add_json(track_app, track_options.json);

    CLI::App& predict_app =
        *app.add_subcommand("predict", "What exact Coulomb friction and the closed form say");
    DriveWords predict_drive;
    PredictWords predict_words;
    predict_drive.add_to(predict_app);
    predict_words.add_to(predict_app);

    const CLI::App& manual_app = *app.add_subcommand("manual", "Print the manual page")->group("");

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
            std::cerr << "\"" << argv[1] << "\" is not a command of shakerd\n";
        return app.exit(e) == 0 ? exit_ok : exit_input;
    }
    if (run_app.parsed()) {
        if (!settings.empty()) read_run_settings(settings, run_options);
        run_options.drive = run_drive.over(run_options.drive);
        if (periods > 0) run_options.periods = periods;
        if (settle >= 0) run_options.settle = settle;
        if (!scene.empty()) run_options.scene = scene;
        set_frames(run_options.pictures, run_frames);
        if (no_identify) run_options.identify = false;
        if (open_loop) run_options.closed_loop = false;
        run(run_options);
    }
    if (serve_app.parsed()) serve(serve_options);
    if (check_app.parsed() && !check(check_options)) return exit_device;
    if (devices_app.parsed()) list_devices(devices_options);
    if (from != "best")
        replay_options.from = from == "raw" ? ReplayOptions::From::raw : ReplayOptions::From::tracks;
    replay_options.real_time = speed == "real";
    if (replay_app.parsed())
        return confined(replay_options.file.string(), confinement_for(replay_options.file),
                        [&] { return replay(replay_options) ? exit_ok : exit_not_identical; });
    if (recover_app.parsed()) {
        Confinement allowed = confinement_for(recover_options.file);
        allowed.writes_files = true;
        return confined(recover_options.file.string(), allowed,
                        [&] { return recover(recover_options) ? exit_ok : exit_not_identical; });
    }
    if (export_app.parsed()) {
        if (format == "mat") export_options.format = ExportOptions::Format::mat;
        Confinement allowed = confinement_for(export_options.file);
        allowed.writes_files = true;
        return confined(export_options.file.string(), allowed, [&] {
            export_recording(export_options);
            return exit_ok;
        });
    }
    if (reduce_app.parsed()) {
        set_frames(reduce_options.pictures, reduce_frames);
        reduce_session(reduce_options);
    }
    if (track_app.parsed()) track_session(track_options);
    if (manual_app.parsed()) std::cout << manual_of(app);
    if (predict_app.parsed()) predict_words.print(predict_drive.over({}));
    return exit_ok;
}

}  // namespace shaker
