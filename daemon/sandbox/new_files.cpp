#include "daemon/sandbox/new_files.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
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

NewFile::NewFile(std::filesystem::path file) : file_{std::move(file)} {
    if (file_.empty()) return;
    const int fd = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    made_ = fd >= 0;  // what else is wrong is reported when it is written
    if (made_) ::close(fd);
}

NewFile::~NewFile() {
    std::error_code ignored;
    if (made_ && std::filesystem::is_empty(file_, ignored)) std::filesystem::remove(file_, ignored);
}

NewRecording::NewRecording(std::filesystem::path file)
    : file_{std::move(file)}, folder_{beside(file_, ".unfinished")} {
    std::error_code error;
    if (std::filesystem::create_directory(folder_, error)) return;
    throw InputError{error ? folder_.string() + ": cannot be created: " + error.message()
                           : folder_.string() +
                                 ": exists; another program writes this recording, or one was killed and "
                                 "the folder can be removed"};
}

NewRecording::~NewRecording() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::filesystem::path NewRecording::working() const { return folder_ / file_.filename(); }

void NewRecording::keep() const {
    const std::filesystem::path pictures = recorded::pictures_folder(working());
    const std::filesystem::path journal = beside(working(), ".journal");
    if (std::filesystem::exists(pictures)) h5::rename_new(pictures, recorded::pictures_folder(file_));
    if (std::filesystem::exists(journal)) h5::rename_new(journal, beside(file_, ".journal"));
    h5::rename_new(working(), file_);
}

}  // namespace shaker::sandbox
