#include "tests/support/recording/disk_faults.hpp"

#include <spdlog/fmt/fmt.h>

#include <cerrno>

#include "daemon/manual/command.hpp"
#include "daemon/recording/journal.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recorded_content.hpp"

namespace shaker::test {

namespace {

constexpr std::int64_t gib = std::int64_t{1} << 30U;
constexpr std::int64_t four_segments =
    1'026'252'800;            // of pictures: one and the one after it, of two cameras
constexpr int periods = 200;  // 14 s: longer than the longest stall

std::string error(const char* call, const char* ending, int number) {
    return fmt::format("{} {} 3 {} 0", call, ending, number);
}

std::map<std::string, std::string> variables(const DiskFault& fault, const std::filesystem::path& folder) {
    std::map<std::string, std::string> all{
        {"LD_PRELOAD", test::build_dir() + "/preload_disk_faults.so"},
        {"SHAKER_DISK_FOLDER", std::filesystem::canonical(folder).string()}};
    if (!fault.fault.empty()) all["SHAKER_DISK_FAULT"] = fault.fault;
    if (fault.room >= 0) all["SHAKER_DISK_ROOM"] = std::to_string(fault.room);
    return all;
}

void look_at(const std::filesystem::path& recording, AfterFault& after) {
    const RecordedContent content = content_of(recording);
    after.wrong.insert(after.wrong.end(), content.wrong.begin(), content.wrong.end());
    after.until_s = content.until_s;
    after.missing = content.missing;
    for (const CameraContent& camera : content.cameras) {
        after.produced += camera.produced;
        after.stored += camera.stored;
        after.dropped += camera.dropped;
    }
    for (const recording::LogEntry& entry : recording::read_log(recorded::RecordingReader{recording}))
        if (entry.text.find("recorder") != std::string::npos ||
            entry.text.find("recorded") != std::string::npos)
            after.journal_says_why = true;
}

void expect_stopped_softly(const DiskFault& fault, const std::filesystem::path& folder, AfterFault& after) {
    if (after.status != manual::exit_device)
        after.wrong.push_back(fmt::format("exit status {}", after.status));
    if (!after.came_down_softly) after.wrong.emplace_back("the drive did not come down softly");
    const Outcome recover = shakerd("recover run.nxs", folder);
    if (recover.status != 0) {
        after.wrong.push_back("recover: " + recover.err);
        return;
    }
    look_at(folder / "run.nxs", after);
    if (!after.journal_says_why && !fault.mute)
        after.wrong.emplace_back(
            "the recovered recording does not contain the reason for the end of the run");
    if (after.until_s < fault.least_s)
        after.wrong.push_back(fmt::format("recovered up to {:.3f} s only", after.until_s));
}

}  // namespace

const std::vector<DiskFault>& disk_faults() {
    static const std::vector<DiskFault> all{
        {.name = "none", .fault = "", .finished = true},
        {.name = "full before the start", .fault = "", .room = gib / 2, .refused = true},
        {.name = "no room for the first pictures", .fault = "", .room = gib + 100'000'000, .refused = true},
        {.name = "filled to the mark in mid run", .fault = "", .room = gib + four_segments + 4'400'000},
        {.name = "ENOSPC of all from 3 s on", .fault = error("any", "*", ENOSPC), .mute = true},
        {.name = "EIO of the series", .fault = error("write", ".nxs.part", EIO)},
        {.name = "EIO of the pictures", .fault = error("write", ".h5", EIO)},
        {.name = "EIO of the journal", .fault = error("write", ".journal", EIO), .mute = true},
        {.name = "EIO of fdatasync of the series", .fault = error("sync", ".nxs.part", EIO)},
        {.name = "EIO of fdatasync of the pictures", .fault = error("sync", ".h5", EIO)},
        {.name = "stall of 5 s", .fault = "any * 3 0 5", .finished = true},
        {.name = "stall of 10 s", .fault = "any * 3 0 10", .finished = true},
    };
    return all;
}

AfterFault run_with(const DiskFault& fault, const std::filesystem::path& folder) {
    AfterFault after;
    {
        const Environment around{variables(fault, folder)};
        const Outcome run = shakerd(
            fmt::format(
                "run --rig sim: --threads --real-time --no-identify --frames full --phi 2.17 --periods {} "
                "-o run.nxs --scene '{}'",
                periods, test::source_dir() + "/tests/support/slow_cameras.toml"),
            folder);
        after.status = run.status;
        after.words = run.status == 0 ? "" : run.err;
        after.came_down_softly = run.err.find("soft stop") != std::string::npos;
    }
    if (fault.refused) {
        if (after.status != manual::exit_input)
            after.wrong.push_back(fmt::format("exit status {}", after.status));
        if (!std::filesystem::is_empty(folder)) after.wrong.emplace_back("something was written");
    } else if (fault.finished) {
        if (after.status != manual::exit_ok) {
            after.wrong.push_back(fmt::format("exit status {}", after.status));
            return after;
        }
        look_at(folder / "run.nxs", after);
    } else {
        expect_stopped_softly(fault, folder, after);
    }
    return after;
}

}  // namespace shaker::test
