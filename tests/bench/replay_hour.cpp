// Replay of an hour without pictures: time, memory, identity to the bit, error of v_D against the truth.
//   --seconds S of experiment (3600)   --file F: the recording, kept (else a temporary one)
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>

#include "daemon/commands/replay.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/reduction/reduction.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/recording/long_run.hpp"

namespace {

using namespace shaker;

const char* option(int argc, char** argv, const char* name, const char* otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

struct Cost {
    int status = -1;
    double wall_s = 0, cpu_s = 0, peak_gb = 0;
};

double seconds_of(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

/// Cost of a command in a separate process, so that its memory is measured alone. Its standard output goes to
/// a file.
Cost cost_of(const std::filesystem::path& said, const std::function<int()>& work) {
    const auto began = std::chrono::steady_clock::now();
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
        int status = 1;
        if (std::freopen(said.c_str(), "w", stdout) != nullptr) try {
                status = work();
            } catch (const std::exception& e) {
                std::cerr << e.what() << '\n';
            }
        std::fflush(nullptr);
        ::_exit(status);
    }
    int status = 0;
    rusage usage{};
    if (child < 0 || ::wait4(child, &status, 0, &usage) != child) return {};
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(),
            seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime),
            1024e-9 * static_cast<double>(usage.ru_maxrss)};
}

int record(const std::filesystem::path& file, double seconds) {
    const test::LongStreams run = test::make_long_streams({.seconds = seconds});
    recording::Recorder recording{file, run.header, {.unfinished = recording::Unfinished::discard}};
    test::record_raw(recording, run.streams);
    recording.writer().scalar("truth/v_D", run.v_D);
    const reduction::Reduction r =
        reduce(measurement_of(run.streams, run.header.frequency_hz, run.from_s, run.to_s));
    recording.finish(run.streams, r, run.from_s, run.to_s);
    return 0;
}

/// The number before " numbers" in the output of a replay; 0 unless it reports that they are identical.
double compared(const std::filesystem::path& said) {
    std::ifstream in{said};
    std::string line;
    while (std::getline(in, line))
        if (const std::string words = "replay: identical ("; line.starts_with(words))
            return std::atof(line.c_str() + words.size());
    return 0;
}

bench::Row row(const char* what, double seconds, const Cost& cost) {
    return {{"step", std::string{what}},
            {"experiment", seconds, "s", 6},
            {"wall", cost.wall_s, "s"},
            {"processor", cost.cpu_s, "s"},
            {"peak memory", cost.peak_gb, "GB"}};
}

}  // namespace

int main(int argc, char** argv) {
    const double seconds = std::atof(option(argc, argv, "--seconds", "3600"));
    const std::string kept = option(argc, argv, "--file", "");
    std::string folder = (std::filesystem::temp_directory_path() / "shakerd-bench-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) return 1;
    const std::filesystem::path file = kept.empty() ? folder + "/long.nxs" : kept, said = folder + "/said";

    const Cost recorded = cost_of(said, [&] { return record(file, seconds); });
    Cost replayed;
    bench::Table table;
    table.add(row("make, reduce, record", seconds, recorded));
    if (recorded.status == 0) {
        replayed = cost_of(said, [&] { return commands::replay({.file = file, .json = false}) ? 0 : 4; });
        const recorded::RecordingReader reader{file};
        const double off = reader.scalar("results/v_D") - reader.scalar("truth/v_D");
        bench::Row of_replay = row("replay", seconds, replayed);
        of_replay.push_back({"numbers compared", compared(said), "", 10});
        of_replay.push_back({"identical", std::string{replayed.status == 0 ? "yes" : "no"}});
        of_replay.push_back({"true v_D", 1e6 * reader.scalar("truth/v_D"), "um/s", 8});
        of_replay.push_back({"v_D off", off / reader.scalar("results/v_D_errors"), "standard errors"});
        table.add(std::move(of_replay));
    }
    table.print(argc, argv);
    std::filesystem::remove_all(folder);
    return replayed.status == 0 ? 0 : 1;
}
