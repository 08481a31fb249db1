// Recordings of runs that SIGKILL ends at random moments: recovered and lost data
//   --count N (200): runs with 2 x 200 pictures a second; a tenth as many with 2 x 1000, one at a time
//   --seed N (1)   --jobs N (2): runs at a time   --folder PATH (the temporary one): on the disk under test
#include "tests/support/recording/kills.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace shaker;
constexpr double allowed_s = 0.6;  // largest allowed loss of a series

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

/// Time for which the disk delays a small file that is synced repeatedly: the cost of the disk itself.
class DiskProbe {
public:
    explicit DiskProbe(const std::filesystem::path& folder)
        : file_{folder / "probe"}, descriptor_{::open(file_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600)} {
        thread_ = std::jthread{[this](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                const auto begin = std::chrono::steady_clock::now();
                if (::pwrite(descriptor_, "probe", 5, 0) != 5 || ::fdatasync(descriptor_) != 0) return;
                const double s =
                    std::chrono::duration<double>{std::chrono::steady_clock::now() - begin}.count();
                worst_s_ = std::max(worst_s_, s);
                std::this_thread::sleep_for(std::chrono::milliseconds{50});
            }
        }};
    }
    DiskProbe(const DiskProbe&) = delete;
    DiskProbe& operator=(const DiskProbe&) = delete;
    ~DiskProbe() {
        thread_ = {};
        ::close(descriptor_);
        std::error_code ignored;
        std::filesystem::remove(file_, ignored);
    }
    /// Seconds, at the end.
    double worst_s() {
        thread_ = {};
        return worst_s_;
    }

private:
    std::filesystem::path file_;
    int descriptor_;
    double worst_s_ = 0;
    std::jthread thread_;
};

std::string of(std::ptrdiff_t some, std::size_t all) { return fmt::format("{} of {}", some, all); }

bench::Row row(const std::string& what, const std::filesystem::path& folder,
               const std::function<std::vector<test::Kill>()>& run) {
    std::filesystem::create_directories(folder);
    DiskProbe probe{folder};
    const std::vector<test::Kill> kills = run();
    const double disk_s = probe.worst_s();
    std::vector<double> series, pictures;
    for (const test::Kill& k : kills) {
        if (!test::went_well(k))
            std::fprintf(stderr, "killed at %.3f s: %s\n", k.at_s,
                         k.wrong.empty() ? "" : k.wrong.front().c_str());
        if (!k.recovered) continue;
        series.push_back(k.series_lost_s);
        pictures.push_back(k.pictures_lost);
    }
    const auto count = [&](auto member) { return of(std::ranges::count(kills, true, member), kills.size()); };
    bench::Row r{
        {"run", what},
        {"recovered", count(&test::Kill::recovered)},
        {"content verified",
         of(std::ranges::count_if(kills, [](const auto& k) { return k.wrong.empty(); }), kills.size())},
        {"whole when recovered again", count(&test::Kill::whole)},
        {"replayed to the bit", count(&test::Kill::replayed)},
        {"with results", count(&test::Kill::reduced)}};
    if (series.empty()) return r;
    r.push_back({"series lost, median", median(series), "s"});
    r.push_back({"worst series lost", std::ranges::max(series), "s"});
    r.push_back({"allowed", allowed_s, "s"});
    r.push_back({"beyond it",
                 of(std::ranges::count_if(series, [](double s) { return s > allowed_s; }), series.size())});
    r.push_back({"longest fdatasync of 5 bytes beside it", disk_s, "s"});
    r.push_back({"pictures lost a camera, median", median(pictures)});
    r.push_back({"worst pictures lost", std::ranges::max(pictures)});
    return r;
}

}  // namespace

int main(int argc, char** argv) {
    const int count = bench::whole_option(argc, argv, "--count", 200, 1);
    const auto seed = static_cast<std::uint64_t>(bench::whole_option(argc, argv, "--seed", 1, 0));
    const int jobs = bench::whole_option(argc, argv, "--jobs", 2, 1);
    const auto folder = bench::own_folder(argc, argv, "shakerd-kills");
    bench::Table table;
    test::KilledRun slow{.scene = test::source_dir() + "/tests/support/slow_cameras.toml"};
    table.add(row("2 x 200 pictures a second", folder,
                  [&] { return test::kill_runs(slow, count, seed, jobs, folder / "slow"); }));
    const int full = std::max(1, count / 10);
    table.add(row("2 x 1000 pictures a second", folder,
                  [&] { return test::kill_runs({}, full, seed + 1, 1, folder / "full"); }));
    table.print(argc, argv);
    std::error_code ignored;
    std::filesystem::remove(folder / "slow", ignored);  // failed runs are kept
    std::filesystem::remove(folder / "full", ignored);
    std::filesystem::remove(folder, ignored);
}
