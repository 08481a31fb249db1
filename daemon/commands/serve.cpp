#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>
#include <utility>

#include "daemon/bench/bench.hpp"
#include "daemon/catalogue/catalogue.hpp"
#include "daemon/commands/serve_settings.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/remote/server.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/service/bench_service.hpp"
#include "daemon/service/bounded_log.hpp"
#include "daemon/service/heartbeats.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr Range ports{0, 65535};

constexpr std::array serve_arguments{
    Argument{
        .name = "--settings",
        .value = "FILE",
        .help = "TOML file with the tables [serve] and [run]; options on the command line replace its values",
        .kind = Kind::file,
        .must_exist = true},
    Argument{.name = "--rig",
             .value = "RIG",
             .help = "Rig file (TOML) that names the devices, or sim: for the simulated bench",
             .kind = Kind::file,
             .otherwise = "as in the settings, else sim:"},
    manual::scene_argument,
    manual::whole_option("--http-port", "PORT", ports, "Port of page, metrics and streams; 0: any free port",
                         {}, "as in the settings, else 8080"),
    manual::whole_option("--scpi-port", "PORT", ports,
                         "Port of the instrument language (SCPI); 0: any free port", {},
                         "as in the settings, else 5025"),
    Argument{.name = "--page",
             .value = "FOLDER",
             .help = "Folder of the page's files",
             .kind = Kind::folder,
             .otherwise = "as in the settings, else the program's own page",
             .must_exist = true},
    Argument{.name = "--recordings",
             .value = "FOLDER",
             .help = "Folder of the recordings",
             .kind = Kind::folder,
             .otherwise = "as in the settings, else .",
             .must_exist = true}};

/// Reads the settings files again while the daemon runs. Either all new settings take effect or none.
class Reload {
public:
    /// All references must outlive this object. settings: the present ones, from the daemon's start.
    Reload(const ServeOptions& options, const ServeSettings& settings, const bench::Bench& bench,
           service::BenchPort& bench_port, remote::Server& server)
        : options_{options}, settings_{settings}, bench_{bench}, bench_port_{bench_port}, server_{server} {}

    /// Reads the files and orders the new drive, periods, limits, token, names and page. The bench's log
    /// reports the result. Refused while the shaker is driven, without reading a file; for an error in the
    /// files; for a rig file that the record of the commissioning does not cover; and for a change that needs
    /// a restart of the daemon (rig, scene, address, ports, socket, folder of recordings, longest recording,
    /// pictures, identification, closed loop, mains). The log names changed tables of
    /// the rig file or scene other than [limits], which are ignored. Never throws.
    void read();

private:
    void require_same(const ServeSettings& now) const;

    ServeOptions options_;
    ServeSettings settings_;
    const bench::Bench& bench_;
    service::BenchPort& bench_port_;
    remote::Server& server_;
};

template <class T>
void require_unchanged(const char* what, const T& now, const T& then) {
    if (now != then) throw InputError{fmt::format("{} was changed; restart the daemon to apply it", what)};
}

void Reload::require_same(const ServeSettings& now) const {
    const run::RunOptions &a = now.run, &b = settings_.run;
    require_unchanged("rig", a.rig, b.rig);
    require_unchanged("scene", a.scene, b.scene);
    require_unchanged("frames", a.pictures, b.pictures);
    require_unchanged("identify", a.identify, b.identify);
    require_unchanged("closed_loop", a.closed_loop, b.closed_loop);
    require_unchanged("mains_hz", a.mains_hz, b.mains_hz);
    require_unchanged("address", now.server.address, settings_.server.address);
    require_unchanged("http_port", now.server.http_port, settings_.server.http_port);
    require_unchanged("scpi_port", now.server.scpi_port, settings_.server.scpi_port);
    require_unchanged("scpi_socket", now.server.scpi_socket, settings_.server.scpi_socket);
    require_unchanged("recordings", now.recordings, settings_.recordings);
    require_unchanged("plans", now.plans, settings_.plans);
    require_unchanged("longest_recording_s", now.longest_recording_s, settings_.longest_recording_s);
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
class ServeSignals {
public:
    explicit ServeSignals(service::BenchService& session) {
        on_call = &session;
        handle(SIGTERM, leave_softly);
        handle(SIGINT, leave_softly);
        handle(SIGHUP, ask_for_reload);
    }
    ServeSignals(const ServeSignals&) = delete;
    ServeSignals& operator=(const ServeSignals&) = delete;
    ~ServeSignals() { on_call = nullptr; }

private:
    static void handle(int signal, void (*handler)(int)) {
        struct sigaction action {};
        action.sa_handler = handler;
        sigaction(signal, &action, nullptr);
    }
};

// Runs until SIGTERM or SIGINT, then stops the drive softly and finishes the recording.
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
    const ServeSignals signals{session};
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

int act_on_serve(const manual::Values& values) {
    ServeOptions options{.settings = values.text("--settings"),
                         .rig = values.text("--rig"),
                         .scene = values.text("--scene"),
                         .page = values.text("--page"),
                         .recordings = values.text("--recordings")};
    if (values.has("--http-port")) options.http_port = values.whole("--http-port");
    if (values.has("--scpi-port")) options.scpi_port = values.whole("--scpi-port");
    serve(options);
    return manual::exit_ok;
}

}  // namespace

manual::Command serve_row() {
    return {.name = "serve",
            .summary = "Run the daemon: a bench on call with page and remote control",
            .details = "The daemon runs until SIGTERM or SIGINT. SIGHUP reads the settings again.",
            .arguments = serve_arguments,
            .example = "shakerd serve --rig sim:",
            .exit_statuses = {manual::exit_device},
            .act = act_on_serve};
}

}  // namespace shaker::commands
