#include "daemon/run/run_settings.hpp"

#include <spdlog/fmt/fmt.h>

namespace shaker::run {

void read_run_settings(const std::filesystem::path& file, RunOptions& options) {
    SettingsTable root = SettingsTable::from_file(file);
    read_run_table(root.table("run"), options);
    root.finish();
}

void read_run_table(SettingsTable run, RunOptions& options) {
    PointSettings point{.drive = options.drive, .plan = options.plan};
    options.rig = run.text("rig", options.rig);
    if (run.has("scene")) options.scene = run.folder() / run.text("scene");
    for (const PointField& field : point_fields) {
        if (field.key.empty() || !run.has(field.key)) continue;
        const auto [least, most] = field.allowed;
        field.set(point, field.whole()
                             ? run.integer(field.key, static_cast<int>(least), static_cast<int>(most), 0)
                             : run.number(field.key, field.allowed));
    }
    for (SettingsTable& overtone : run.tables("harmonic")) {
        const int n = overtone.integer("n", 3, most_driven, 0);
        if (n == 0) overtone.fail("n", "missing; 3 to 8 is allowed");
        const double share = overtone.number("share", drive_limits.share);
        point.drive.overtones.at(static_cast<std::size_t>(n - 3)) =
            std::polar(share, overtone.number("phase_rad", drive_limits.phi, 0));
        overtone.finish();
    }
    options.drive = point.drive;
    options.plan = point.plan;
    if (run.has("frames"))
        options.pictures = static_cast<recorded::KeptPictures>(
            run.choice("frames", {"off", "first-second", "region", "full"}));
    options.identify = run.flag("identify", options.identify);
    options.closed_loop = run.flag("closed_loop", options.closed_loop);
    options.mains_hz = run.number("mains_hz", drive_limits.mains, options.mains_hz);
    run.finish();
}

std::string run_settings_text(const RunOptions& o) {
    std::string overtones;
    for (std::size_t i = 0; i < o.drive.overtones.size(); ++i)
        if (const std::complex<double> share = o.drive.overtones[i]; share != 0.0)
            overtones += fmt::format("\n[[run.harmonic]]\nn = {}\nshare = {}\nphase_rad = {}\n", i + 3,
                                     std::abs(share), std::arg(share));
    return overtones.insert(
        0,
        fmt::format(
            "[run]\nrig = \"{}\"\nfrequency_hz = {}\ngamma_mps2 = {}\nrho = {}\nphi_rad = {}\nperiods = {}\n"
            "settle_periods = {}\nframes = \"{}\"\nidentify = {}\nclosed_loop = {}\nmains_hz = {}\n",
            o.rig, o.drive.frequency, o.drive.gamma, o.drive.rho, o.drive.phi, o.plan.periods, o.plan.settle,
            name(o.pictures), o.identify, o.closed_loop, o.mains_hz));
}

}  // namespace shaker::run
