#include "daemon/run_settings.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

namespace shaker {

void read_run_settings(const std::filesystem::path& file, RunOptions& options) {
    SettingsTable root = SettingsTable::from_file(file);
    read_run_table(root.table("run"), options);
    root.finish();
}

void read_run_table(SettingsTable run, RunOptions& options) {
    Drive& d = options.drive;
    options.rig = run.text("rig", options.rig);
    if (run.has("scene")) options.scene = run.folder() / run.text("scene");
    d.frequency = run.number("frequency_hz", drive_limits.frequency, d.frequency);
    d.gamma = run.number("gamma_mps2", drive_limits.gamma, d.gamma);
    d.rho = run.number("rho", drive_limits.rho, d.rho);
    d.phi = run.number("phi_rad", drive_limits.phi, d.phi);
    options.periods = run.integer("periods", 2, most_periods, options.periods);
    if (run.has("frames"))
        options.pictures = static_cast<KeptPictures>(run.choice("frames", {"off", "region", "full"}, 1));
    options.identify = run.flag("identify", options.identify);
    options.closed_loop = run.flag("closed_loop", options.closed_loop);
    options.mains_hz = run.number("mains_hz", drive_limits.mains, options.mains_hz);
    run.finish();
}

std::string run_settings_text(const RunOptions& o) {
    return fmt::format(
        "[run]\nrig = \"{}\"\nfrequency_hz = {}\ngamma_mps2 = {}\nrho = {}\nphi_rad = {}\nperiods = {}\n"
        "frames = \"{}\"\nidentify = {}\nclosed_loop = {}\nmains_hz = {}\n",
        o.rig, o.drive.frequency, o.drive.gamma, o.drive.rho, o.drive.phi, o.periods, name(o.pictures),
        o.identify, o.closed_loop, o.mains_hz);
}

}  // namespace shaker
