// Output of the installed service when it dies or is stopped while it drives the mock bench, under systemd:
// service_deaths COUNT [--json]. Run by tests/systemd/run deaths. The deaths take turns; five are one of each
// kind. Times to the death are random: up to 2 s with a fixed seed, with SHAKER_NIGHTLY=1 up to 8 s with
// SHAKER_SEED.
// A drive is at its full level after 8 s: SIGKILL, after which the daemon can do nothing, comes then.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/table.hpp"
#include "tests/mock/mock_bench.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr double rate_hz = 48000, full_scale = 2147483648.0;
constexpr double silent = 1e-5, audible = 3e-2;  // shares of full scale; dither is below the first
constexpr double largest_allowed_step = 0.01;
constexpr const char* trip_error = "101,";  // SCPI's number for a trip
constexpr int most_goes = 6;  // to a death in mid-drive: a computer that stands still ends drives
const fs::path folder{"/dev/shm/bench"};

enum class Death { segv, kill, watchdog, memory, stop };
constexpr std::array<const char*, 5> names{"SIGSEGV", "SIGKILL", "watchdog", "out of memory", "stop at 1 Hz"};

std::string output_of(const std::string& command) {
    std::string text;
    FILE* const pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return {};
    for (std::array<char, 256> part{}; std::fgets(part.data(), part.size(), pipe) != nullptr;)
        text += part.data();
    pclose(pipe);
    if (text.ends_with('\n')) text.pop_back();
    return text;
}

std::string property(const std::string& name) {
    return output_of("systemctl show --value --property=" + name + " shakerd.service");
}

template <class Condition>
bool soon(double limit_s, Condition condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>{limit_s};
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(milliseconds{20});
    }
    return true;
}

template <class Condition>
void wait_for(const std::string& what, double limit_s, Condition condition) {
    if (!soon(limit_s, condition))
        throw std::runtime_error{"not within " + std::to_string(limit_s) + " s: " + what};
}

/// The mock DAC's output, read from the file of its codes.
class Output {
public:
    explicit Output(mock::Converter& converter) : converter_{converter} {}
    [[nodiscard]] std::int64_t now() const { return converter_.due(mock::host_now()); }
    /// The drive, shares of full scale, of the timeline samples [from, to).
    [[nodiscard]] std::vector<double> drive(std::int64_t from, std::int64_t to) const {
        wait_for("the output is taken", 10,
                 [&] { return fs::file_size(folder / "codes") >= 8 * static_cast<std::uintmax_t>(to); });
        std::ifstream in{folder / "codes", std::ios::binary};
        in.seekg(8 * from);
        std::vector<std::int32_t> codes(2 * static_cast<std::size_t>(to - from));
        in.read(reinterpret_cast<char*>(codes.data()), static_cast<std::streamsize>(4 * codes.size()));
        std::vector<double> drive;
        for (std::size_t i = 0; i < codes.size(); i += 2) drive.push_back(codes[i] / full_scale);
        return drive;
    }
    [[nodiscard]] double level(double seconds) const {
        const std::int64_t to = now() - static_cast<std::int64_t>(0.05 * rate_hz);
        double most = 0;
        for (const double v :
             drive(std::max<std::int64_t>(0, to - static_cast<std::int64_t>(seconds * rate_hz)), to))
            most = std::max(most, std::abs(v));
        return most;
    }

private:
    mock::Converter& converter_;
};

// Takes memory in the service's group until the kernel ends the largest process there, which is the daemon.
void exhaust_memory() {
    const fs::path group = "/sys/fs/cgroup/memory" + property("ControlGroup");
    const fs::path unified = "/sys/fs/cgroup" + property("ControlGroup");
    const bool first_version = fs::exists(group / "memory.limit_in_bytes");
    const fs::path in = first_version ? group : unified;
    std::int64_t used = 0;
    std::ifstream{in / (first_version ? "memory.usage_in_bytes" : "memory.current")} >> used;
    constexpr std::int64_t spare = 8 << 20;
    std::ofstream{in / (first_version ? "memory.limit_in_bytes" : "memory.max")} << used + spare
                                                                                 << std::flush;
    const pid_t child = ::fork();
    if (child == 0) {
        std::ofstream{"/proc/self/oom_score_adj"}
            << -1000;  // not allowed everywhere; the daemon is larger anyhow
        std::ofstream{in / "cgroup.procs"} << ::getpid() << std::flush;
        std::vector<char> taken;
        for (int i = 0; i < 400; ++i) {
            taken.resize(taken.size() + (1 << 20), 1);
            std::this_thread::sleep_for(milliseconds{2});
            std::ifstream procs{in / "cgroup.procs"};
            if (std::distance(std::istream_iterator<int>{procs}, {}) <= 2 && i > 16) break;  // daemon ended
        }
        ::_exit(0);
    }
    ::waitpid(child, nullptr, 0);
}

struct Seen {
    double level = 0, step = 0;  // shares of full scale
    double silent_after_s = NAN;
};

class Service {
public:
    explicit Service(mock::Converter& converter) : output_{converter} {}

    /// Starts the service and a drive, and waits until the drive is audible. False when it tripped before, as
    /// on a computer that stands still; the service is then started again.
    bool drive(bool slowly) {
        output_of("systemctl reset-failed shakerd.service 2>&1");
        if (property("ActiveState") != "active") output_of("systemctl start shakerd.service 2>&1");
        if (!soon(20, [] { return property("StatusText") == "idle"; })) {
            output_of("systemctl stop shakerd.service 2>&1");
            return false;
        }
        TcpClient client{fs::path{"/run/shakerd/scpi"}};
        client.send(slowly ? "APPL:BIH 1,0.01,0.5,0" : "APPL:BIH 20,8,0.5,0");
        client.send("OUTP ON");
        bool tripped = false;
        wait_for("the drive is audible", 60, [&] {
            tripped = client.ask("SYST:STAT?") == "\"tripped\"";
            const std::string error = client.ask("SYST:ERR?");
            if (!error.starts_with("0,") && !error.starts_with(trip_error))
                throw std::runtime_error{"the drive: " + error};
            return tripped || output_.level(0.3) > audible;
        });
        if (tripped) output_of("systemctl stop shakerd.service 2>&1");
        return !tripped;
    }

    /// Level 0: the daemon has not died of it.
    Seen end(Death how) {
        const pid_t daemon = std::stoi(property("MainPID"));
        const std::int64_t from = output_.now();
        switch (how) {
            case Death::segv:
                ::kill(daemon, SIGSEGV);
                break;
            case Death::kill:
                ::kill(daemon, SIGKILL);
                break;
            case Death::watchdog:
                ::kill(daemon, SIGSTOP);
                break;
            case Death::memory:
                exhaust_memory();
                break;
            case Death::stop:
                output_of("systemctl stop shakerd.service 2>&1");
                break;
        }
        const auto ended = [&] { return property("MainPID") != std::to_string(daemon); };
        if (how == Death::memory && !soon(10, ended)) {  // the kernel ended the other process
            output_of("systemctl stop shakerd.service 2>&1");
            return {};
        }
        if (how != Death::stop) wait_for("the daemon has ended", 30, ended);
        std::this_thread::sleep_for(milliseconds{700});
        return judge(from);
    }

private:
    [[nodiscard]] Seen judge(std::int64_t from) const {
        Seen seen;
        const auto before = static_cast<std::int64_t>(0.3 * rate_hz);
        const std::vector<double> heard = output_.drive(from - before, output_.now());
        for (std::size_t i = 1; i < heard.size(); ++i) {
            if (static_cast<std::int64_t>(i) < before) seen.level = std::max(seen.level, std::abs(heard[i]));
            seen.step = std::max(seen.step, std::abs(heard[i] - heard[i - 1]));
            if (std::abs(heard[i]) > silent)
                seen.silent_after_s = static_cast<double>(static_cast<std::int64_t>(i) - before) / rate_hz;
        }
        return seen;
    }

    Output output_;
};

struct Row {
    int count = 0, steps = 0;
    double level = 0, step = 0, silent_after_s = 0;
};

int run(int argc, char** argv) {
    const int count = std::atoi(argv[1]);
    fs::create_directories(folder);
    fs::permissions(folder, fs::perms::owner_all | fs::perms::group_all | fs::perms::others_all);
    mock::MockBenchSettings settings;
    settings.folder = folder;
    settings.plugin = "/usr/lib/shakerd/shaker_mock_pcm.so";
    settings.log_codes = true;
    settings.iiod_port = 30431;
    SettingsTable scene = SettingsTable::from_text(
        "[shaker]\namplifier_gain = 3\n[walker]\nmu_k = 0.9\nmu_s = 0.9\n[top]\nframe_rate_hz = "
        "100\n[side]\nframe_rate_hz "
        "= 100\n",
        "scene");
    settings.scene = simulated::read_scene(scene);
    mock::MockBench bench{settings};
    for (const fs::directory_entry& file : fs::directory_iterator{folder})  // the service is another user's
        fs::permissions(file, fs::perms::owner_all | fs::perms::group_all | fs::perms::others_all);
    Service service{bench.dac()};
    const char* const seed = std::getenv("SHAKER_SEED");
    std::mt19937_64 random{nightly() && seed != nullptr ? std::strtoull(seed, nullptr, 10) : 1};
    std::uniform_real_distribution<double> later_s{0, nightly() ? 8.0 : 2.0};
    std::array<Row, names.size()> rows{};
    for (int i = 0; i < count; ++i) {
        const auto how = static_cast<std::size_t>(i) % names.size();
        Seen seen;
        for (int go = 0; seen.level < audible; ++go) {
            if (go == most_goes) throw std::runtime_error{"the drive does not start or go on"};
            if (!service.drive(static_cast<Death>(how) == Death::stop)) continue;
            const double wait_s = later_s(random);
            const bool at_full_level = static_cast<Death>(how) == Death::kill && !nightly();
            std::this_thread::sleep_for(std::chrono::duration<double>{at_full_level ? 8 : wait_s});
            seen = service.end(static_cast<Death>(how));
        }
        std::fprintf(stderr, "%3d %-14s level %.3f, largest step %.5f, silent after %.3f s\n", i,
                     names.at(how), seen.level, seen.step, seen.silent_after_s);
        Row& row = rows.at(how);
        ++row.count;
        row.steps += seen.step > largest_allowed_step ? 1 : 0;
        row.level = std::max(row.level, seen.level);
        row.step = std::max(row.step, seen.step);
        row.silent_after_s = std::max(row.silent_after_s, seen.silent_after_s);
    }
    bench::Table table;
    int steps = 0;
    for (std::size_t how = 0; how < names.size(); ++how) {
        const Row& row = rows.at(how);
        steps += row.steps;
        if (row.count > 0)
            table.add({{"death", names.at(how)},
                       {"count", static_cast<double>(row.count)},
                       {"level before", 100 * row.level, "% of full scale"},
                       {"largest step", 100 * row.step, "% of full scale"},
                       {"steps above 1 %", static_cast<double>(row.steps)},
                       {"silent after", 1e3 * row.silent_after_s, "ms", 4}});
    }
    table.print(argc, argv);
    return steps == 0 ? 0 : 1;
}

}  // namespace
}  // namespace shaker::test

int main(int argc, char** argv) try {
    if (argc < 2) {
        std::fputs("usage: service_deaths COUNT [--json]\n", stderr);
        return 2;
    }
    return shaker::test::run(argc, argv);
} catch (const std::exception& e) {
    std::fprintf(stderr, "service_deaths: %s\n", e.what());
    return 3;
}
