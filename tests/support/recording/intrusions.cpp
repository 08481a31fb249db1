#include "tests/support/recording/intrusions.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <mutex>
#include <random>
#include <thread>

#include "daemon/manual/command.hpp"
#include "tests/support/in_parallel.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recorded_content.hpp"

namespace shaker::test {

namespace {

constexpr double longest_s = 4;                             // the run takes about 5 s
constexpr double pictures_s = 0.5;                          // there are some by then
constexpr const char* strange_bytes = "another program's";  // in the file of the name

std::string run_words() {
    return fmt::format(
        "run --rig sim: --threads --real-time --no-identify --frames full --phi 2.17 --periods "
        "40 -o run.nxs --scene '{}/tests/support/slow_cameras.toml'",
        source_dir());
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

void expect_refused(const Outcome& outcome, const std::string& reason, Intrusion& found) {
    if (outcome.status != manual::exit_input || outcome.err.find(reason) == std::string::npos)
        found.wrong.push_back(
            fmt::format("the intruder ended with {}: {}{}", outcome.status, outcome.out, outcome.err));
}

// After the run: the file of the name is unchanged, and moving it away lets the recording be completed.
void look_at_other_file(const Outcome& run, const std::filesystem::path& folder, Intrusion& found) {
    if (run.status != manual::exit_device || run.err.find("another file has this name") == std::string::npos)
        found.wrong.push_back(fmt::format("the run ended with {}: {}", run.status, run.err));
    found.replaced = text_of(folder / "run.nxs") != strange_bytes;
    std::filesystem::rename(folder / "run.nxs", folder / "other");
    const Outcome recover = shakerd("recover run.nxs", folder);
    if (recover.status != 0) found.wrong.push_back("recover: " + recover.out + recover.err);
}

void look_at_recording(const std::filesystem::path& file, Intrusion& found) {
    static std::mutex hdf5;  // it has one user at a time
    const std::scoped_lock lock{hdf5};
    const RecordedContent content = content_of(file);
    found.wrong.insert(found.wrong.end(), content.wrong.begin(), content.wrong.end());
    for (const CameraContent& camera : content.cameras) {
        found.produced += camera.produced;
        found.stored += camera.stored;
        found.dropped += camera.dropped;
        found.lost += camera.produced - camera.dropped - camera.pictures;
    }
    if (found.lost > 0) found.wrong.push_back(fmt::format("{} pictures are missing", found.lost));
    if (found.replaced) found.wrong.emplace_back("a file was replaced");
}

}  // namespace

const char* name(Intruder intruder) noexcept {
    switch (intruder) {
        case Intruder::recover:
            return "recover";
        case Intruder::second_recorder:
            return "second recorder";
        case Intruder::file_of_the_name:
            return "file of the name";
        case Intruder::recover_copy:
            return "recover a copy";
    }
    return "";
}

Intrusion intrude(Intruder intruder, double at_s, const std::filesystem::path& folder) {
    Intrusion found{.intruder = intruder, .at_s = at_s, .wrong = {}};
    Program program{"shakerd", run_words(), folder};
    if (!program.waits_for_content(folder / "run.nxs.journal")) {
        found.wrong.push_back("it did not begin: " + program.wait().err);
        return found;
    }
    if (intruder == Intruder::recover_copy) found.at_s = std::max(at_s, pictures_s);
    std::this_thread::sleep_for(std::chrono::duration<double>{found.at_s});
    if (program.ended()) found.wrong.emplace_back("it had ended before");
    const std::string process = fmt::format("is being recorded by process {}", program.pid());
    if (intruder == Intruder::recover) {
        expect_refused(shakerd("recover run.nxs.part", folder), process, found);
    } else if (intruder == Intruder::second_recorder) {
        expect_refused(shakerd(run_words(), folder), process, found);
    } else if (intruder == Intruder::recover_copy) {
        std::filesystem::copy_file(folder / "run.nxs.part", folder / "run.copy.part");
        expect_refused(shakerd("recover run.copy.part", folder), "another process records", found);
    } else {
        std::ofstream{folder / "run.nxs"} << strange_bytes;
    }
    const Outcome run = program.wait();
    if (intruder == Intruder::file_of_the_name)
        look_at_other_file(run, folder, found);
    else if (run.status != 0)
        found.wrong.push_back(fmt::format("the run ended with {}: {}", run.status, run.err));
    if (std::filesystem::exists(folder / "run.nxs")) look_at_recording(folder / "run.nxs", found);
    return found;
}

std::vector<Intrusion> intrusions(int count, std::uint64_t seed, int jobs,
                                  const std::filesystem::path& folder) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> moment{0, longest_s};
    std::vector<Intrusion> found(static_cast<std::size_t>(count));
    for (Intrusion& one : found) one.at_s = moment(random);
    in_parallel(count, jobs, [&](int i) {
        const std::filesystem::path place = folder / fmt::format("intrusion-{}", i);
        std::filesystem::create_directories(place);
        Intrusion& one = found[static_cast<std::size_t>(i)];
        one = intrude(static_cast<Intruder>(i % intruders), one.at_s, place);
        if (one.wrong.empty()) std::filesystem::remove_all(place);
    });
    return found;
}

}  // namespace shaker::test
