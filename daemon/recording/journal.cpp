#include "daemon/recording/journal.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/crc32c.hpp"

namespace shaker::recording {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
    throw DeviceError{file.string() + ": " + std::generic_category().message(errno)};
}

std::string line_of(const LogEntry& entry) {
    const nlohmann::json j{{"t_s", entry.t_s}, {"state", entry.state}, {"text", entry.text}};
    const std::string body = j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return fmt::format("{:08x} {} {}\n", h5::crc32c(std::as_bytes(std::span{body})), body.size(), body);
}

bool entry_of(const std::string& line, LogEntry& entry) {
    const std::size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (first == std::string::npos || second == std::string::npos) return false;
    const std::string body = line.substr(second + 1);
    if (line.substr(0, second) !=
        fmt::format("{:08x} {}", h5::crc32c(std::as_bytes(std::span{body})), body.size()))
        return false;
    const nlohmann::json j = nlohmann::json::parse(body, nullptr, false);
    if (j.is_discarded() || !j.contains("t_s") || !j.contains("state") || !j.contains("text")) return false;
    entry = {j["t_s"].is_number() ? j["t_s"].get<double>() : NAN, j["state"].get<std::string>(),
             j["text"].get<std::string>()};
    return true;
}

}  // namespace

Journal::Journal(const std::filesystem::path& file)
    : file_{file},
      descriptor_{
          ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0640)} {
    if (descriptor_ < 0) fail(file);
}

void Journal::add(const LogEntry& entry) {
    const std::string line = line_of(entry);
    const ssize_t written = ::write(descriptor_, line.data(), line.size());
    if (written != static_cast<ssize_t>(line.size()) || ::fdatasync(descriptor_) != 0) fail(file_);
}

std::vector<LogEntry> read_journal(const std::filesystem::path& file) {
    std::vector<LogEntry> entries;
    std::ifstream in{file, std::ios::binary};
    LogEntry entry;
    for (std::string line; std::getline(in, line) && entry_of(line, entry);) entries.push_back(entry);
    return entries;
}

}  // namespace shaker::recording
