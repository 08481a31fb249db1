#include "tests/orders/kept_data.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cstdio>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/commands/recover.hpp"
#include "daemon/commands/replay.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/recording/lasting_columns.hpp"

namespace shaker::orders {

namespace {

/// Sends standard output to nowhere during its life: commands print their results there.
class Mute {
public:
    Mute() : out_{::dup(STDOUT_FILENO)} {
        std::fflush(stdout);
        const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
        ::dup2(nowhere, STDOUT_FILENO);
        ::close(nowhere);
    }
    ~Mute() {
        std::fflush(stdout);
        ::dup2(out_, STDOUT_FILENO);
        ::close(out_);
    }
    Mute(const Mute&) = delete;
    Mute& operator=(const Mute&) = delete;

private:
    int out_;
};

void recover(const std::filesystem::path& part) {
    const Mute mute;
    sandbox::NewRecording fresh{commands::recovered_files({.file = part}).file};
    static_cast<void>(commands::recover({.file = part, .working = fresh.working()}));
    if (std::filesystem::exists(fresh.working())) fresh.keep();
}

// Rows that other programs could read before the recovery are in the recovered file, unchanged.
void compare_rows(const std::filesystem::path& before, const std::filesystem::path& file,
                  std::vector<std::string>& lost) {
    const recorded::RecordingReader was{before, recorded::RecordingReader::Open::growing}, is{file};
    const hid_t grown = was.opened().entry.get();
    for (const std::string& path : test::lasting_columns(is)) {
        if (!h5::exists(grown, path)) continue;
        const h5::Bytes old = h5::read_first_bytes(grown, path);
        const std::uint64_t rows = old.values.size() / old.row;
        const std::uint64_t same = test::same_rows(old, h5::read_bytes(is.opened().entry.get(), path));
        if (same < rows)
            lost.push_back(fmt::format("{}: {}: {} of {} rows are as they were", file.filename().string(),
                                       path, same, rows));
    }
}

void add_log(const std::filesystem::path& file, std::vector<std::string>& texts) {
    for (const recording::LogEntry& e : recording::read_log(recorded::RecordingReader{file}))
        texts.push_back(e.text);
}

}  // namespace

std::vector<std::string> faults_of(const std::filesystem::path& file) try {
    std::vector<std::string> faults;
    for (const std::string& what : recorded::RecordingReader{file}.damage())
        faults.push_back(fmt::format("{}: {}", file.filename().string(), what));
    const Mute mute;
    if (!commands::replay({.file = file}))
        faults.push_back(fmt::format("{}: the replay differs", file.filename().string()));
    return faults;
} catch (const std::exception& e) {
    return {fmt::format("{}: {}", file.filename().string(), e.what())};
}

std::vector<std::string> faults_of_campaigns(const std::filesystem::path& folder, bool made) {
    std::vector<std::string> faults;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        if (!std::filesystem::exists(entry.path() / campaign::plan_name)) continue;
        const std::string name = entry.path().filename().string();
        try {
            const campaign::StoredCampaign stored = campaign::read_campaign(entry.path());
            for (const std::string& remark : stored.progress.remarks)
                faults.push_back(fmt::format("{}: {}", name, remark));
        } catch (const std::exception& e) {
            faults.push_back(fmt::format("{}: {}", name, e.what()));
        }
        if (made && !std::filesystem::exists(entry.path() / campaign::table_name))
            faults.push_back(fmt::format("{}: has no table of points", name));
    }
    return faults;
}

std::size_t left_open() noexcept {
    h5::be_quiet();
    return static_cast<std::size_t>(std::max<ssize_t>(0, H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL)));
}

bool recovers(const std::filesystem::path& file) try {
    recover(file);
    return true;
} catch (const InputError&) {
    return false;
}

std::vector<std::string> lost_after_kill(const std::filesystem::path& folder,
                                         const std::vector<std::pair<double, std::string>>& remarks) {
    std::vector<std::string> lost, kept;  // kept: the logs of all recordings
    std::vector<double> begun_s;          // of each that was recovered
    std::vector<std::filesystem::path> parts;
    for (const auto& entry : std::filesystem::recursive_directory_iterator{folder}) {
        if (entry.path().extension() == ".nxs") try {
                add_log(entry.path(), kept);
            } catch (const InputError&) {  // a file of another program
            }
        if (entry.path().extension() == ".part" &&
            !std::filesystem::exists(std::filesystem::path{entry.path()}.replace_extension()))
            parts.push_back(entry.path());
    }
    for (const std::filesystem::path& part : parts) try {
            const std::vector<recording::LogEntry> written =
                recording::read_journal(std::filesystem::path{part}.replace_extension(".journal"));
            std::filesystem::path before = part;
            before += ".before";
            std::filesystem::copy_file(part, before);
            recover(part);
            const std::filesystem::path file = std::filesystem::path{part}.replace_extension();
            add_log(file, kept);
            if (!written.empty()) begun_s.push_back(written.front().t_s);
            compare_rows(before, file, lost);
            for (const std::string& fault : faults_of(file)) lost.push_back(fault);
        } catch (const std::exception& e) {
            lost.push_back(fmt::format("{}: {}", part.filename().string(), e.what()));
        }
    for (const auto& [at_s, remark] : remarks) {
        const bool during = std::ranges::any_of(begun_s, [&](double begun) { return begun <= at_s; });
        if (during && std::ranges::none_of(kept, [&](const std::string& text) {
                return text.find(remark) != std::string::npos;
            }))
            lost.push_back(fmt::format("\"{}\" at {:.3f} s is in no recording", remark, at_s));
    }
    return lost;
}

}  // namespace shaker::orders
