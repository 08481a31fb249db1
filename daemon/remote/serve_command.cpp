#include "daemon/remote/serve_command.hpp"

#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>

#include "daemon/drive_rig.hpp"
#include "daemon/paced_dac.hpp"
#include "daemon/remote/reload.hpp"
#include "daemon/remote/serve_settings.hpp"
#include "daemon/remote/service_log.hpp"
#include "daemon/remote/service_notes.hpp"
#include "daemon/session.hpp"
#include "drivers/region_camera.hpp"

namespace shaker {

namespace {

std::atomic<Session*> on_call{nullptr};
std::atomic<bool> reload_asked{false};

extern "C" void leave_softly(int /*signal*/) {
    if (Session* session = on_call) session->leave();
}

extern "C" void ask_for_reload(int /*signal*/) { reload_asked = true; }

/// While it lives SIGTERM and SIGINT bring this session to its end, SIGHUP has the settings read again.
class Signals {
public:
    explicit Signals(Session& session) {
        on_call = &session;
        handle(SIGTERM, leave_softly);
        handle(SIGINT, leave_softly);
        handle(SIGHUP, ask_for_reload);
    }
    Signals(const Signals&) = delete;
    Signals& operator=(const Signals&) = delete;
    ~Signals() { on_call = nullptr; }

private:
    static void handle(int signal, void (*handler)(int)) {
        struct sigaction action {};
        action.sa_handler = handler;
        sigaction(signal, &action, nullptr);
    }
};

}  // namespace

void serve(const ServeOptions& options) {
    const ServiceLog log;
    const ServeSettings settings = serve_settings(options);
    OpenRig bench = open_rig(settings.run.rig, settings.run.scene, World::Pace::paced);
    for (const std::string& granted : bench.granted) spdlog::info("{}", granted);
    Rig& rig = bench.rig;
    if (bench.world) rig.dac = std::make_unique<PacedDac>(std::move(rig.dac));
    if (settings.run.pictures == KeptPictures::region) take_regions(rig);
    const Limits limits = limits_on_call(bench.limits);
    Acquisition acquisition{rig, nullptr, limits, settings.run.drive.frequency};
    const DacInfo dac = rig.dac->info();
    Output output{dac,    settings.run.drive.frequency,     trigger_rate(rig), dac.block_frames,
                  limits, rig.accelerometer->info().rate_hz};
    Desk desk;
    Session session{bench,
                    acquisition,
                    {.run = settings.run, .record = settings.record, .beside = true, .mu = settings.mu},
                    desk};
    Server server{desk, settings.server};
    Reload reload{options, settings, bench, desk, server};
    spdlog::info("page and metrics: http://{}:{}/  instrument language: {} port {}", settings.server.address,
                 server.http_port(), settings.server.address, server.scpi_port());
    const Signals signals{session};
    ServiceNotes notes;
    std::uint64_t logged = 0;
    const Execution execution = drive_rig(
        bench, acquisition, output, true,
        [&](const Take& take, Lanes& lanes) {
            const bool any = session.step(take, lanes);
            if (const auto state = desk.state()) notes.look(*state, lanes.gathered, session.leaving());
            for (const BenchEvent& e : desk.events(logged)) {
                logged = e.number;
                spdlog::log(e.kind == "trip" ? spdlog::level::warn : spdlog::level::info, "{:.3f} s {}: {}",
                            e.t_s, e.kind, e.text);
            }
            if (reload_asked.exchange(false)) reload.read();
            return any;
        },
        [&] { return session.done(); }, [&] { return session.record(); });
    for (const std::string& refused : execution.refused) spdlog::warn("{}", refused);
}

}  // namespace shaker
