// Recordings of the bench on call by minutes: memory while recording, gaps between watchdog signals,
// completion
//   --minutes LIST (1,10,60) of experiment   --rate F (1000): pictures a second of each camera
//   --pictures off|region|full (off)   --real-time: not faster than an experiment
//   --folder PATH (the temporary one): on the disk under test
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string_view>
#include <thread>

#include "daemon/service/bench_service.hpp"
#include "daemon/service/heartbeats.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/stall_probe.hpp"

namespace {

using namespace shaker;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>{Clock::now() - t}.count(); }

double resident_bytes() {
    std::size_t size = 0, resident = 0;
    std::ifstream{"/proc/self/statm"} >> size >> resident;
    return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

/// The service manager: hears the watchdog signals of this process.
class Manager {
public:
    explicit Manager(const std::filesystem::path& folder) : path_{(folder / "notify").string()} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
        ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
        ::setenv("WATCHDOG_USEC", "2000000", 1);  // as in systemd/shakerd.service
    }
    ~Manager() {
        ear_ = {};
        ::close(socket_);
    }
    Manager(const Manager&) = delete;
    Manager& operator=(const Manager&) = delete;
    /// Longest time without a signal since the last call, s.
    double longest_gap_s() {
        const std::scoped_lock lock{mutex_};
        return std::exchange(longest_s_, 0);
    }

private:
    std::string path_;
    int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    std::mutex mutex_;
    Clock::time_point fed_ = Clock::now();
    double longest_s_ = 0;
    std::jthread ear_{[this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            pollfd ready{socket_, POLLIN, 0};
            char bytes[512];
            const ssize_t n = ::poll(&ready, 1, 50) == 1 ? ::recv(socket_, bytes, sizeof bytes, 0) : 0;
            if (n <= 0 || std::string_view{bytes, static_cast<std::size_t>(n)} != "WATCHDOG=1") continue;
            const std::scoped_lock lock{mutex_};
            longest_s_ = std::max(longest_s_, seconds_since(fed_));
            fed_ = Clock::now();
        }
    }};
};

struct Settings {
    double minutes = 1;
    int rate = 1000;
    recorded::KeptPictures pictures = recorded::KeptPictures::off;
    bool real_time = false;
};

/// Slope of a straight line through points (t, y).
double slope_of(const std::vector<std::pair<double, double>>& points) {
    double t = 0, y = 0, ty = 0, tt = 0;
    if (points.size() < 2) return NAN;
    for (const auto& [a, b] : points) t += a, y += b;
    t /= static_cast<double>(points.size());
    y /= static_cast<double>(points.size());
    for (const auto& [a, b] : points) ty += (a - t) * (b - y), tt += (a - t) * (a - t);
    return ty / tt;
}

/// The operator: records one run of the given length and leaves when its file is complete.
class Operator {
public:
    Operator(const Settings& settings, Manager& manager)
        : settings_{settings}, manager_{manager}, to_s_{60 * settings.minutes} {}
    void act(const service::BenchState& s, service::BenchPort& port, service::BenchService& service) {
        const bool idle = s.state == run::RunState::idle;
        if (step_ == 0 && idle) {
            port.order({service::Record{true, "long", settings_.pictures}, {}});
            port.order({service::Begin{40}, {}});
            begun_s_ = s.now_s;
            ++step_;
        } else if (step_ == 1 && s.state == run::RunState::run) {
            if (s.now_s - begun_s_ > warm_up_s && s.now_s > looked_s_ + 1) {
                looked_s_ = s.now_s;
                memory.emplace_back(s.now_s, resident_bytes());
            }
            if (s.now_s < begun_s_ + to_s_) return;
            recording_gap_s = manager_.longest_gap_s();
            port.order({service::End{}, {}});
            ended_ = Clock::now();
            ++step_;
        } else if (step_ == 2 && idle) {
            finish_s = seconds_since(ended_);
            finish_gap_s = manager_.longest_gap_s();
            service.leave();
            ++step_;
        }
    }
    std::vector<std::pair<double, double>> memory;  // master time, resident bytes
    double recording_gap_s = 0, finish_gap_s = 0, finish_s = 0;

private:
    static constexpr double warm_up_s = 60;  // queues and caches reach their size; shorter runs have no slope
    const Settings& settings_;
    Manager& manager_;
    double to_s_, begun_s_ = 0, looked_s_ = 0;
    int step_ = 0;
    Clock::time_point ended_;
};

bench::Row record(const Settings& settings, const std::filesystem::path& folder) {
    std::ofstream{folder / "scene.toml"} << "[top]\nframe_rate_hz = " << settings.rate
                                         << "\n[side]\nframe_rate_hz = " << settings.rate << "\n";
    Manager manager{folder};
    const test::StallProbe probe;
    run::RunOptions run;
    run.scene = folder / "scene.toml";
    run.pictures = settings.pictures;
    run.drive.gamma = 1;  // m/s^2; the walker rests on the base, so that it stays in view
    run.threads = true;
    run.real_time = settings.real_time;
    run::Runner runner{{.run = run, .on_call = true, .recordings = folder, .longest_recording_s = 86400}};
    service::BenchPort port;
    service::BenchService service{runner, {.beside = true}, port};
    service::SystemdNotify notes;
    service::BenchHeartbeats heartbeats;
    Operator who{settings, manager};
    std::shared_ptr<const service::BenchState> seen;
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            const bool any = service.step(streams, channels);
            heartbeats.follow(channels, runner.recordings());
            const auto state = port.state();
            notes.report(*state, heartbeats.all(), service.leaving());
            if (std::exchange(seen, state) != state && state->answered >= port.ordered())
                who.act(*state, port, service);
            return any;
        },
        [&] { return service.done(); });
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return {{"recorded", settings.minutes, "min"},
            {"wall", runner.wall_s(), "s"},
            {"memory slope", 1e-3 * slope_of(who.memory), "kB/s"},
            {"peak memory", 1024e-6 * static_cast<double>(usage.ru_maxrss), "MB"},
            {"longest gap recording", who.recording_gap_s, "s"},
            {"finishing took", who.finish_s, "s"},
            {"longest gap finishing", who.finish_gap_s, "s"},
            {"machine stood still", probe.longest_s(), "s"},
            {"file", 1e-6 * static_cast<double>(std::filesystem::file_size(folder / "long.nxs")), "MB"}};
}

}  // namespace

int main(int argc, char** argv) {
    Settings settings{.rate = bench::whole_option(argc, argv, "--rate", 1000, 1)};
    settings.pictures = recorded::kept_pictures_named(bench::option(argc, argv, "--pictures", "off"))
                            .value_or(recorded::KeptPictures::off);
    settings.real_time = std::find(argv, argv + argc, std::string_view{"--real-time"}) != argv + argc;
    const auto folder = bench::own_folder(argc, argv, "shakerd-recording-hour");
    std::istringstream minutes{bench::option(argc, argv, "--minutes", "1,10,60")};
    bench::Table table;
    for (std::string one; std::getline(minutes, one, ',');) {
        settings.minutes = std::atof(one.c_str());
        std::filesystem::create_directories(folder);
        table.add(record(settings, folder));
        std::filesystem::remove_all(folder);
    }
    table.print(argc, argv);
}
