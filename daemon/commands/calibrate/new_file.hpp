#pragma once
// A file that a calibration writes.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::commands {

/// A file that must not exist before; every write reaches the disk's cache at once. InputError, DeviceError.
class NewFile {
public:
    explicit NewFile(std::filesystem::path file) : file_{std::move(file)} {
        if (std::filesystem::exists(file_))
            throw InputError{file_.string() + ": exists and is not overwritten; give another --output"};
    }
    void append(const std::string& text) {
        std::ofstream out{file_, std::ios::binary | std::ios::app};
        out << text << std::flush;
        if (!out) throw DeviceError{file_.string() + ": cannot be written: " + std::strerror(errno)};
    }
    [[nodiscard]] std::string name() const { return file_.string(); }

private:
    std::filesystem::path file_;
};

}  // namespace shaker::commands
