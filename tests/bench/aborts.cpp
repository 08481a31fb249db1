// Time from the bytes of an abort to the ramp, for each door, idle and with busy processors.
//   --count N (1000) aborts a door   --driven N (10) more from a running drive   --load WORD (all)
//   --priority N (60): of the server's thread, as on hardware; 0: ordinary, as on a simulated rig
// Aborts beside a stall of the machine (> 20 ms) are counted apart.
#include <pthread.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "daemon/remote/server.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/service/bench_service.hpp"
#include "drivers/realtime.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/remote/socket_client.hpp"
#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/stall_probe.hpp"

namespace {

using namespace shaker;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::SocketClient;
using test::TcpClient;

/// Stamps the end of the write with which the output answered an abort: the first block of the ramp, or of
/// the silence that it keeps, is with the converter then.
class StampedDac final : public Dac {
public:
    StampedDac(std::unique_ptr<Dac> inner, const acquisition::Channels& channels)
        : inner_{std::move(inner)}, channels_{channels} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return inner_->counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        const std::uint64_t answered = channels_.aborts_answered;
        const PlayTime played = inner_->write(volts, trigger);
        if (answered != stamped_) {
            at_ = Clock::now().time_since_epoch().count();
            stamped_ = answered;
        }
        return played;
    }
    std::int64_t take_back(std::int64_t most) noexcept override { return inner_->take_back(most); }
    void stop() noexcept override { inner_->stop(); }
    [[nodiscard]] std::uint64_t stamped() const noexcept { return stamped_; }
    [[nodiscard]] Clock::time_point at() const noexcept {
        return Clock::time_point{Clock::duration{at_.load()}};
    }

private:
    std::unique_ptr<Dac> inner_;
    const acquisition::Channels& channels_;
    std::atomic<Clock::rep> at_{0};
    std::atomic<std::uint64_t> stamped_{0};
};

/// The daemon's parts in this process, on the simulated rig paced by the clock.
class Daemon {
public:
    Daemon(const std::filesystem::path& folder, int priority) : socket{folder / "scpi"} {
        run::RunOptions options;
        options.scene = test::source_dir() + "/tests/support/slow_cameras.toml";
        options.drive.gamma = 1;
        options.drive.phi = 1.5708;
        options.plan.periods = 4;
        options.identify = false;
        options.trips = folder;
        options.pictures = recorded::KeptPictures::off;
        options.threads = options.real_time = true;
        runner_ = std::make_unique<run::Runner>(
            run::RunnerSettings{.run = options, .on_call = true, .recordings = folder});
        auto stamped = std::make_unique<StampedDac>(std::move(runner_->bench().rig.dac),
                                                    runner_->collector().channels());
        dac = stamped.get();
        runner_->bench().rig.dac = std::move(stamped);
        service_ = std::make_unique<service::BenchService>(
            *runner_, service::BenchServiceSettings{.beside = true}, bench_port);
        server = std::make_unique<remote::Server>(
            bench_port,
            remote::ServerSettings{
                .http_port = 0, .scpi_port = 0, .scpi_socket = socket, .fifo_priority = priority});
        leader_ = std::jthread{[this] {
            runner_->lead(
                [this](const acquisition::Streams& streams, acquisition::Channels& channels) {
                    return service_->step(streams, channels);
                },
                [this] { return service_->done(); });
        }};
    }
    ~Daemon() {
        clear();
        service_->leave();
        leader_.join();
        server.reset();
    }
    [[nodiscard]] bool becomes(run::RunState state) const {
        for (const auto end = Clock::now() + 30s; Clock::now() < end; std::this_thread::sleep_for(2ms))
            if (const auto now = bench_port.state(); now && now->state == state) return true;
        return false;
    }
    void clear() {
        for (int i = 0; i < 1000; ++i) {
            const auto now = bench_port.state();
            if (now && now->state == run::RunState::idle) return;
            if (now && now->may_clear) bench_port.order({service::ClearTrip{}, {}});
            std::this_thread::sleep_for(10ms);
        }
    }
    bool drive() {
        clear();
        bench_port.order({service::Begin{4, 4}, {}});
        return becomes(run::RunState::run);
    }

    std::filesystem::path socket;
    service::BenchPort bench_port;
    StampedDac* dac = nullptr;
    std::unique_ptr<remote::Server> server;

private:
    std::unique_ptr<run::Runner> runner_;
    std::unique_ptr<service::BenchService> service_;
    std::jthread leader_;
};

struct Door {
    std::string name;
    std::function<void()> abort;  // sends the bytes, and takes the answer
    int share = 1;                // of the count: a door that starts a program has fewer
};

const std::string post =
    "POST /api/abort HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";

int run_shakerctl(int port) {
    const std::string at = "http://localhost:" + std::to_string(port) + "/",
                      program = test::build_dir() + "/shakerctl";
    const pid_t child = ::fork();
    if (child == 0) {
        const sched_param ordinary{};
        ::sched_setscheduler(0, SCHED_OTHER, &ordinary);
        if (::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(1);
        ::execl(program.c_str(), "shakerctl", "--at", at.c_str(), "abort", nullptr);
        ::_exit(127);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
}

/// The server closes a page that reads nothing for long, so it is opened with the first abort.
void abort_by(std::optional<SocketClient>& page, int port) {
    if (!page) page.emplace(port);
    page->send(SocketClient::text, R"({"type":"abort"})");
    for (std::string got; got.find(R"("type":"abort")") == std::string::npos;) {
        got = page->next().data;
        if (got.empty()) throw std::runtime_error{"WebSocket: the server closed the page"};
    }
}

std::vector<Door> doors_of(Daemon& daemon, TcpClient& session, std::optional<SocketClient>& page) {
    const int http = daemon.server->http_port(), scpi = daemon.server->scpi_port();
    return {{"SCPI, open session", [&session] { session.ask("ABOR?"); }},
            {"SCPI, new session", [scpi] { TcpClient{scpi}.ask("ABOR?"); }},
            {"Unix socket", [&daemon] { TcpClient{daemon.socket}.ask("ABOR?"); }},
            {"HTTP",
             [http] {
                 TcpClient client{http};
                 client.send_bytes(post);
                 client.rest();
             }},
            {"WebSocket", [&page, http] { abort_by(page, http); }},
            {"shakerctl", [http] { run_shakerctl(http); }, 10}};
}

double quantile(std::vector<double> sorted, double q) {
    return sorted.empty()
               ? 0
               : sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1) + 0.5)];
}

/// Milliseconds to the ramp, sorted. Those beside a stall of the machine are apart.
struct Times {
    std::vector<double> ms, stalled_ms;
};

/// driven: from a running drive.
Times times(Daemon& daemon, const Door& door, int count, bool driven, const test::StallProbe& probe) {
    Times all;
    for (int i = 0; i < count; ++i) {
        if (driven && !daemon.drive()) continue;
        const std::uint64_t before = daemon.dac->stamped();
        const auto begin = Clock::now();
        door.abort();
        for (const auto end = begin + 2s; daemon.dac->stamped() == before && Clock::now() < end;)
            std::this_thread::sleep_for(100us);
        const std::chrono::duration<double, std::milli> took = daemon.dac->at() - begin;
        const bool stalled = probe.longest_s(begin, std::max(Clock::now(), daemon.dac->at())) > 0;
        (stalled ? all.stalled_ms : all.ms)
            .push_back(daemon.dac->stamped() == before ? INFINITY : took.count());
        std::this_thread::sleep_for(std::chrono::microseconds{(i * 7919) % 5000});  // any phase of the block
    }
    std::ranges::sort(all.ms);
    std::ranges::sort(all.stalled_ms);
    return all;
}

struct Load {
    std::string name, conditions;
    int count, driven;
};

void add_rows(bench::Table& table, Daemon& daemon, const Load& load) {
    auto session = std::make_unique<TcpClient>(daemon.server->scpi_port());
    std::optional<SocketClient> page;
    std::vector<Door> doors = doors_of(daemon, *session, page);
    std::deque<TcpClient> sessions;
    const test::StallProbe probe;
    const auto add = [&](const Door& door) {
        const Times moving = times(daemon, door, load.driven, true, probe);
        const Times all = times(daemon, door, std::max(1, load.count / door.share), false, probe);
        table.add({{"door", door.name},
                   {"load", load.name},
                   {"aborts", static_cast<double>(all.ms.size()), "", 6},
                   {"p50", quantile(all.ms, 0.5), "ms"},
                   {"p99.9", quantile(all.ms, 0.999), "ms"},
                   {"worst", quantile(all.ms, 1), "ms"},
                   {"driven", static_cast<double>(moving.ms.size())},
                   {"p50 driven", quantile(moving.ms, 0.5), "ms"},
                   {"worst driven", quantile(moving.ms, 1), "ms"},
                   {"beside a stall", static_cast<double>(all.stalled_ms.size() + moving.stalled_ms.size())},
                   {"worst beside a stall",
                    std::max(quantile(all.stalled_ms, 1), quantile(moving.stalled_ms, 1)), "ms"},
                   {"conditions", load.conditions}});
    };
    for (const Door& door : doors) add(door);
    for (int i = 1; i < 16; ++i) sessions.emplace_back(daemon.server->scpi_port()).ask("*IDN?");
    add({"SCPI, all sessions taken", doors[1].abort});
}

/// Keeps all processors busy: two threads each.
class Busy {
    static void burn(const std::stop_token& stop) {
        const sched_param ordinary{};
        pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);  // not that of its creator
        volatile double x = 1;
        while (!stop.stop_requested())
            for (int i = 0; i < 10000; ++i) x = std::sqrt(x + 1);
    }
    std::deque<std::jthread> threads_;

public:
    Busy() {
        for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i) threads_.emplace_back(burn);
    }
};

}  // namespace

int main(int argc, char** argv) {
    const int count = bench::whole_option(argc, argv, "--count", 1000, 1);
    const int driven = bench::whole_option(argc, argv, "--driven", 10, 0);
    const int priority = bench::whole_option(argc, argv, "--priority", 60, 0);
    const std::string only = bench::option(argc, argv, "--load", "");
    const std::filesystem::path folder = bench::own_folder(argc, argv, "shakerd-aborts");
    bench::Table table;
    {
        Daemon daemon{folder, priority};
        if (!daemon.becomes(run::RunState::idle)) return 1;
        // A client on another machine does not wait for a processor of this one.
        const bool ordinary_client = !use_fifo_priority(80).empty();
        const bool ordinary = priority == 0 || !daemon.server->refused().empty();
        const std::string conditions =
            std::string{"simulated rig paced by the clock, blocks of 5 ms; server of "} +
            (ordinary ? "ordinary" : "real-time") + " priority, client of " +
            (ordinary_client ? "ordinary" : "real-time") + " priority; shakerctl includes its start";
        const auto wanted = [&](const std::string& load) { return load.find(only) != std::string::npos; };
        if (wanted("none")) add_rows(table, daemon, {"none", conditions, count, driven});
        if (wanted("busy processors")) {
            const Busy busy;
            add_rows(table, daemon, {"busy processors", conditions, count, driven});
        }
    }
    table.print(argc, argv);
    std::filesystem::remove_all(folder);
}
