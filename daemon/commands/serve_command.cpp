#include "daemon/commands/serve_command.hpp"

#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/commands/reload.hpp"
#include "daemon/commands/serve_settings.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/service/bench_service.hpp"
#include "daemon/service/bounded_log.hpp"
#include "daemon/service/heartbeats.hpp"
#include "daemon/service/systemd_notify.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

namespace shaker::commands {

namespace {

std::atomic<service::BenchService*> on_call{nullptr};
std::atomic<bool> reload_asked{false};

extern "C" void leave_softly(int /*signal*/) {
    if (service::BenchService* session = on_call) session->leave();
}

extern "C" void ask_for_reload(int /*signal*/) { reload_asked = true; }

// Recordings are read only then.
bool at_rest(const service::BenchPort& bench_port) {
    const auto state = bench_port.state();
    return state && !driving(state->state) && state->state != run::RunState::finishing;
}

/// During its lifetime, SIGTERM and SIGINT end the service (a second one aborts the drive), and SIGHUP
/// reloads the settings.
class Signals {
public:
    explicit Signals(service::BenchService& session) {
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
    const service::BoundedLog log;
    const ServeSettings settings = serve_settings(options);
    run::RunOptions run = settings.run;
    run.threads = run.real_time = true;
    run::Runner runner{{.run = run,
                        .on_call = true,
                        .recordings = settings.recordings,
                        .longest_recording_s = settings.longest_recording_s}};
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    if (const std::string& why = runner.bench().not_commissioned; !why.empty())
        spdlog::warn("the drive cannot be started: {}", why);
    service::BenchPort bench_port;
    service::BenchService session{
        runner, {.beside = true, .mu = settings.mu, .plans = settings.plans}, bench_port};
    catalogue::Catalogue recordings{
        {.folder = settings.recordings, .may_read = [&bench_port] { return at_rest(bench_port); }},
        bench_port.results()};
    remote::ServerSettings served = settings.server;
    if (runner.bench().world == nullptr) served.fifo_priority = fifo_priority::doors;
    remote::Server server{bench_port, served, &recordings};
    if (served.fifo_priority > 0) session.publish_grant({"doors", server.refused()});
    if (const std::string refused = server.refused(); !refused.empty()) spdlog::warn("{}", refused);
    Reload reload{options, settings, runner.bench(), bench_port, server};
    spdlog::info("page and metrics: http://{}:{}/  instrument language: {} port {}", settings.server.address,
                 server.http_port(), settings.server.address, server.scpi_port());
    if (!settings.server.scpi_socket.empty())
        spdlog::info("instrument language for this computer: {}", settings.server.scpi_socket.string());
    const Signals signals{session};
    try {
        remote::Server::load_all();
    } catch (const DeviceError& e) {
        spdlog::warn("{}", e.what());
    }
    service::SystemdNotify notes;
    service::BenchHeartbeats heartbeats;
    service::Heartbeat& doors = heartbeats.all().add("doors", std::chrono::milliseconds{500});
    std::uint64_t logged = 0;
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            const bool any = session.step(streams, channels);
            heartbeats.follow(channels, runner.recordings());
            if (server.alive()) doors.beat();
            if (const auto state = bench_port.state())
                notes.report(*state, heartbeats.all(), session.leaving());
            for (const service::BenchEvent& e : bench_port.events(logged)) {
                logged = e.number;
                spdlog::log(
                    e.kind == "trip" || e.kind == "warning" ? spdlog::level::warn : spdlog::level::info,
                    "{:.3f} s {}: {}", e.t_s, e.kind, e.text);
            }
            if (reload_asked.exchange(false)) reload.read();
            return any;
        },
        [&] { return session.done(); });
}

}  // namespace shaker::commands
