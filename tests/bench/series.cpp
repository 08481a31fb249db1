// All series of a bench into a live recording in real time: cost, and age of the newest rows for a reader.
//   --seconds N (20)   --folder FOLDER (in the build folder): its file is removed afterwards
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "tests/bench/table.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/remote/live_streams.hpp"

namespace shaker {
namespace {

namespace fs = std::filesystem;

std::string option(int argc, char** argv, const char* name, const std::string& otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

/// Output of the reader after its end.
nlohmann::json ages_of(const fs::path& file, double seconds) {
    const std::string command =
        test::source_dir() + "/tests/support/newest_rows '" + file.string() + "' " + std::to_string(seconds);
    std::string said;
    std::FILE* reader = ::popen(command.c_str(), "r");
    if (reader == nullptr) throw std::runtime_error{"no reader can be started"};
    for (int c = std::fgetc(reader); c != EOF; c = std::fgetc(reader)) said += static_cast<char>(c);
    if (::pclose(reader) != 0) throw std::runtime_error{"the reader failed: " + command};
    return nlohmann::json::parse(said);
}

bench::Row row_of(const test::LiveStreams& streams, const test::LiveCost& cost, const std::string& reader) {
    return {{"reader", reader},
            {"time", cost.wall_s, "s"},
            {"recorder", 100 * cost.recorder_s / cost.wall_s, "% of a core"},
            {"handing over", 100 * cost.feeder_s / cost.wall_s, "% of a core"},
            {"longest flush", 1e3 * cost.longest_step_s, "ms"},
            {"longest hand-over", 1e3 * cost.longest_add_s, "ms"},
            {"feeder late", 1e3 * cost.worst_behind_s, "ms"},
            {"lost", static_cast<double>(cost.lost), "", 9},
            {"file", 1e-6 * static_cast<double>(cost.bytes) / streams.seconds, "MB/s"}};
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) try {
    using namespace shaker;
    test::LiveStreams streams;
    streams.seconds = std::max(2.0, std::atof(option(argc, argv, "--seconds", "20").c_str()));
    const fs::path folder = fs::path{option(argc, argv, "--folder", test::build_dir())} / "bench_series_file";
    const auto fresh = [&] {
        fs::remove_all(folder);
        fs::create_directories(folder);
        return folder / "run.nxs";
    };
    bench::Table table;
    table.add(row_of(streams, test::record_live(fresh(), streams), "none"));
    const fs::path file = fresh();
    nlohmann::json ages;
    std::exception_ptr failure;
    std::thread reader{[&] {
        try {
            ages = ages_of(file.string() + ".part", streams.seconds);
        } catch (...) {
            failure = std::current_exception();
        }
    }};
    const test::LiveCost cost = test::record_live(file, streams);
    reader.join();
    if (failure) std::rethrow_exception(failure);
    bench::Row row = row_of(streams, cost, "h5py, SWMR");
    for (const char* stream : {"drive", "accelerometer", "frames"}) {
        row.push_back(
            {std::string{stream} + " age, median", 1e3 * ages[stream]["median_s"].get<double>(), "ms"});
        row.push_back(
            {std::string{stream} + " age, worst", 1e3 * ages[stream]["worst_s"].get<double>(), "ms"});
    }
    table.add(std::move(row));
    table.print(argc, argv);
    fs::remove_all(folder);
} catch (const std::exception& error) {
    std::fprintf(stderr, "bench_series: %s\n", error.what());
    return 1;
}
