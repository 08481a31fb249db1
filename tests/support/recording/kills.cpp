#include "tests/support/recording/kills.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>
#include <thread>

#include "tests/support/in_parallel.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recorded_content.hpp"

namespace shaker::test {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double least_s = 0.3;  // of the first kill

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>{Clock::now() - t}.count(); }

std::string bytes_of(const std::filesystem::path& file) {
    std::ostringstream all;
    all << std::ifstream{file, std::ios::binary}.rdbuf();
    return all.str();
}

// Time of the first line in the journal: the start of the run.
void look_at_losses(const RecordedContent& content, Kill& kill) {
    kill.wrong.insert(kill.wrong.end(), content.wrong.begin(), content.wrong.end());
    // The wait for the journal may end late; the pictures give a lower bound for the progress of the run.
    for (const CameraContent& camera : content.cameras)
        kill.at_s = std::max(kill.at_s, camera.last_picture_s);
    kill.series_lost_s = kill.at_s - content.until_s;
    for (const CameraContent& camera : content.cameras)
        kill.pictures_lost =
            std::max(kill.pictures_lost, (kill.at_s - camera.last_picture_s) * camera.rate_hz);
}

}  // namespace

bool went_well(const Kill& kill) {
    return kill.recovered && kill.whole && kill.replayed && kill.wrong.empty();
}

Kill kill_run(const KilledRun& run, double at_s, const std::filesystem::path& folder) {
    Kill kill;
    kill.at_s = at_s;
    {
        const std::string scene = run.scene.empty() ? "" : fmt::format("--scene '{}' ", run.scene.string());
        Program program{
            "shakerd",
            fmt::format(
                "run --rig sim: --threads --real-time --no-identify --frames full --phi 2.17 {}--periods {} "
                "-o run.nxs",
                scene, run.periods),
            folder};
        if (!program.waits_for_content(folder / "run.nxs.journal")) {
            kill.wrong.push_back("it did not begin: " + program.wait().err);
            return kill;
        }
        const auto begun = Clock::now();
        while (seconds_since(begun) < at_s && !program.ended())
            std::this_thread::sleep_for(std::chrono::milliseconds{1});
        ::kill(program.pid(), SIGKILL);
        kill.at_s = seconds_since(begun);
        if (program.wait().status != 128 + SIGKILL) kill.wrong.emplace_back("it had ended before");
    }
    const Outcome recover = shakerd("recover run.nxs", folder);
    kill.recovered = recover.status == 0 && recover.out.starts_with("recovered:");
    if (!kill.recovered) {
        kill.wrong.push_back(recover.out + recover.err);
        return kill;
    }
    const std::string made = bytes_of(folder / "run.nxs");
    const Outcome again = shakerd("recover run.nxs", folder);
    kill.whole = again.status == 0 && bytes_of(folder / "run.nxs") == made;
    if (!kill.whole) kill.wrong.push_back(again.out + again.err);
    kill.reduced = recover.out.find("no results") == std::string::npos;
    const Outcome replay = shakerd("replay run.nxs", folder);
    kill.replayed = replay.status == 0;
    if (!kill.replayed) kill.wrong.push_back(replay.out + replay.err);
    static std::mutex hdf5;  // it has one user at a time
    const std::scoped_lock lock{hdf5};
    look_at_losses(content_of(folder / "run.nxs"), kill);
    return kill;
}

std::vector<Kill> kill_runs(const KilledRun& run, int count, std::uint64_t seed, int jobs,
                            const std::filesystem::path& folder) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> moment{least_s, run.longest_s};
    std::vector<double> at_s;
    std::generate_n(std::back_inserter(at_s), count, [&] { return moment(random); });
    std::vector<Kill> kills(at_s.size());
    in_parallel(count, jobs, [&](int i) {
        const auto k = static_cast<std::size_t>(i);
        const std::filesystem::path place = folder / fmt::format("kill-{}", i);
        std::filesystem::create_directories(place);
        kills[k] = kill_run(run, at_s[k], place);
        if (went_well(kills[k])) std::filesystem::remove_all(place);
    });
    return kills;
}

}  // namespace shaker::test
