#include "daemon/sandbox/new_files.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::sandbox {

namespace {

std::filesystem::path beside(std::filesystem::path file, const char* ending) { return file += ending; }

}  // namespace

NewFolder::NewFolder(const std::filesystem::path& file, std::filesystem::path folder)
    : folder_{std::move(folder)} {
    std::error_code reported_later;
    made_ = std::filesystem::exists(file) && std::filesystem::create_directories(folder_, reported_later);
}

NewFolder::~NewFolder() {
    std::error_code not_empty;
    if (made_) std::filesystem::remove(folder_, not_empty);
}

NewFile::NewFile(std::filesystem::path file)
    : file_{std::move(file)}, fd_{::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)} {
    if (fd_ >= 0) return;
    if (errno == EEXIST)
        throw InputError{file_.string() + ": exists already; nothing is overwritten, choose another name"};
    throw DeviceError{file_.string() + ": cannot be created: " + std::strerror(errno)};
}

NewFile::~NewFile() {
    std::error_code ignored;
    if (std::filesystem::is_empty(file_, ignored)) std::filesystem::remove(file_, ignored);
}

NewRecording::NewRecording(std::filesystem::path file)
    : file_{std::move(file)}, folder_{beside(file_, ".unfinished")} {
    const bool made = ::mkdir(folder_.c_str(), S_IRWXU) == 0;
    if (!made && errno != EEXIST)
        throw InputError{folder_.string() + ": cannot be created: " + std::strerror(errno)};
    if (std::filesystem::is_symlink(folder_))
        throw InputError{folder_.string() + ": exists and is a link; remove it"};
    auto lock = h5::FileLock::take_folder(folder_, h5::Sharing::alone);
    if (!lock) throw InputError{folder_.string() + ": exists; another program writes this recording"};
    lock_ = std::move(*lock);
    if (made) return;
    for (const auto& left : std::filesystem::directory_iterator{folder_})  // by a killed program
        std::filesystem::remove_all(left.path());
}

NewRecording::~NewRecording() {
    std::error_code ignored;
    if (!complete_) std::filesystem::remove_all(folder_, ignored);
}

std::filesystem::path NewRecording::working() const { return folder_ / file_.filename(); }

void NewRecording::keep() {
    complete_ = true;
    std::vector<std::pair<std::filesystem::path, std::filesystem::path>> moved;
    const auto move = [&](const std::filesystem::path& from, const std::filesystem::path& to) {
        h5::rename_new(from, to);
        moved.emplace_back(from, to);
    };
    const std::filesystem::path pictures = recorded::pictures_folder(working());
    const std::filesystem::path journal = beside(working(), ".journal");
    std::error_code ignored;
    try {
        if (std::filesystem::exists(pictures)) move(pictures, recorded::pictures_folder(file_));
        if (std::filesystem::exists(journal)) move(journal, beside(file_, ".journal"));
        move(working(), file_);
    } catch (const std::exception& e) {
        for (const auto& [from, to] : moved) std::filesystem::rename(to, from, ignored);
        throw DeviceError{
            fmt::format("{}; the recording is complete, move it out of {}", e.what(), folder_.string())};
    }
    h5::sync_folder(file_.parent_path());
    std::filesystem::remove_all(folder_, ignored);
}

}  // namespace shaker::sandbox
