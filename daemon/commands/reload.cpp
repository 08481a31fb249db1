#include "daemon/commands/reload.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "daemon/service/bench_service.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

template <class T>
void same(const char* what, const T& now, const T& then) {
    if (now != then) throw InputError{fmt::format("{} was changed; restart the daemon to apply it", what)};
}

}  // namespace

void Reload::require_same(const ServeSettings& now) const {
    const run::RunOptions &a = now.run, &b = settings_.run;
    same("rig", a.rig, b.rig);
    same("scene", a.scene, b.scene);
    same("frames", a.pictures, b.pictures);
    same("identify", a.identify, b.identify);
    same("closed_loop", a.closed_loop, b.closed_loop);
    same("mains_hz", a.mains_hz, b.mains_hz);
    same("address", now.server.address, settings_.server.address);
    same("http_port", now.server.http_port, settings_.server.http_port);
    same("scpi_port", now.server.scpi_port, settings_.server.scpi_port);
    same("scpi_socket", now.server.scpi_socket, settings_.server.scpi_socket);
    same("recordings", now.recordings, settings_.recordings);
    same("plans", now.plans, settings_.plans);
    same("longest_recording_s", now.longest_recording_s, settings_.longest_recording_s);
}

void Reload::read() {
    const auto log = [this](const std::string& text) {
        const auto now = bench_port_.state();
        bench_port_.log(now ? now->now_s : 0, "settings", text);
    };
    if (const auto now = bench_port_.state(); now && driving(now->state))
        return log(fmt::format(
            "settings not reloaded: the settings cannot change while the bench is {}; stop the drive "
            "first",
            row_of(now->state).shown));
    if (options_.settings.empty())
        return log(
            "nothing was read: the daemon was started without --settings FILE; to change mu, order it "
            "(shakerctl mu)");
    try {
        const ServeSettings now = serve_settings(options_);
        require_same(now);
        const bench::NewLimits bench = limits_now(bench_, now.run.rig, now.run.scene);
        const std::filesystem::path bench_file{now.run.scene.empty() ? now.run.rig : now.run.scene.string()};
        std::string done = fmt::format("settings reloaded: {}", options_.settings.string());
        if (std::filesystem::exists(bench_file))
            done += fmt::format(" and the limits in {}", bench_file.string());
        if (!bench.ignored.empty())
            done += fmt::format("; changed but ignored until a restart of the daemon: {}",
                                fmt::join(bench.ignored, ", "));
        bench_port_.order({service::Adopt{now.run.drive, now.run.plan, bench.limits},
                           [this, log, now, done](const std::string& refused) {
                               if (!refused.empty()) return log("settings not reloaded: " + refused);
                               server_.adopt(now.server);
                               log(done);
                           }});
    } catch (const std::exception& e) {
        log(fmt::format("settings not reloaded: {}", e.what()));
    }
}

}  // namespace shaker::commands
