#include "daemon/run_log.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "drivers/errors.hpp"
#include "drivers/replay/crc32c.hpp"

namespace shaker {

namespace {

constexpr std::size_t word = 32, sentence = 512;  // bytes of the longest

[[noreturn]] void fail(const std::filesystem::path& file) {
    throw DeviceError{file.string() + ": " + std::generic_category().message(errno)};
}

std::string line_of(const LogEntry& entry) {
    const nlohmann::json j{{"t_s", std::isfinite(entry.t_s) ? nlohmann::json(entry.t_s) : nlohmann::json()},
                           {"state", entry.state},
                           {"text", entry.text}};
    const std::string body = j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return fmt::format("{:08x} {} {}\n", crc32c(std::as_bytes(std::span{body})), body.size(), body);
}

bool entry_of(const std::string& line, LogEntry& entry) {
    const std::size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (first == std::string::npos || second == std::string::npos) return false;
    const std::string body = line.substr(second + 1);
    if (line.substr(0, second) !=
        fmt::format("{:08x} {}", crc32c(std::as_bytes(std::span{body})), body.size()))
        return false;
    const nlohmann::json j = nlohmann::json::parse(body, nullptr, false);
    if (j.is_discarded() || !j.contains("t_s") || !j.contains("state") || !j.contains("text")) return false;
    entry = {j["t_s"].is_number() ? j["t_s"].get<double>() : NAN, j["state"].get<std::string>(),
             j["text"].get<std::string>()};
    return true;
}

}  // namespace

std::vector<GroupLayout> run_log_places() {
    return {{"events",
             "NXcollection",
             {},
             {{"t", "s", Place::Kind::numbers, 0, false},
              {"state", "", Place::Kind::texts, word, false},
              {"text", "", Place::Kind::texts, sentence, false}},
             0},
            {"measurements",
             "NXcollection",
             {},
             {{"from", "s", Place::Kind::numbers, 0, false}, {"to", "s", Place::Kind::numbers, 0, false}},
             0}};
}

void write(SessionWriter& file, const LogEntry& entry) {
    file.rows("events", {{"t", "s", {entry.t_s}}});
    file.texts("events/state", {entry.state});
    file.texts("events/text", {entry.text});
}

void write(SessionWriter& file, const MeasuredPart& part) {
    file.rows("measurements", {{"from", "s", {part.from_s}}, {"to", "s", {part.to_s}}});
}

std::optional<MeasuredPart> read_measurement(const SessionReader& file) {
    const std::vector<double> from = file.numbers("measurements/from"), to = file.numbers("measurements/to");
    if (from.size() != to.size()) throw InputError{"recording: measurements has columns of different length"};
    if (from.empty()) return std::nullopt;
    return MeasuredPart{from.back(), to.back()};
}

std::vector<LogEntry> read_log(const SessionReader& file) {
    const std::vector<double> t = file.numbers("events/t");
    const std::vector<std::string> state = file.texts("events/state"), text = file.texts("events/text");
    if (state.size() != t.size() || text.size() != t.size())
        throw InputError{"recording: events has columns of different length"};
    std::vector<LogEntry> entries;
    for (std::size_t i = 0; i < t.size(); ++i) entries.push_back({t[i], state[i], text[i]});
    return entries;
}

Journal::Journal(const std::filesystem::path& file)
    : file_{file},
      descriptor_{
          ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0640)} {
    if (descriptor_ < 0) fail(file);
}

Journal::~Journal() { ::close(descriptor_); }

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

}  // namespace shaker
