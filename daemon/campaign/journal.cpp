#include "daemon/campaign/journal.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"

namespace shaker::campaign {

namespace {

using nlohmann::json;

template <class T, std::size_t N>
std::string word_of(T value, const std::string_view (&words)[N]) {
    return std::string{words[static_cast<std::size_t>(value)]};
}

// Writes the members of an entry.
struct Put {
    json& j;
    void operator()(const char* key, double v) const { j[key] = v; }
    void operator()(const char* key, int v) const { j[key] = v; }
    void operator()(const char* key, bool v) const { j[key] = v; }
    void operator()(const char* key, const std::string& v) const { j[key] = v; }
    template <class T, std::size_t N>
    void operator()(const char* key, const T& v, const std::string_view (&words)[N]) const {
        j[key] = word_of(v, words);
    }
};

// Reads the members of an entry. Throws json::exception or std::out_of_range for a line that is not one.
struct Take {
    const json& j;
    void operator()(const char* key, double& v) const {
        v = j.at(key).is_null() ? unknown : j[key].get<double>();
    }
    void operator()(const char* key, int& v) const {
        if (!j.at(key).is_number_integer()) throw std::out_of_range{key};
        const auto wide = j[key].get<std::int64_t>();
        if (!std::in_range<int>(wide)) throw std::out_of_range{key};
        v = static_cast<int>(wide);
    }
    void operator()(const char* key, bool& v) const { v = j.at(key).get<bool>(); }
    void operator()(const char* key, std::string& v) const { v = j.at(key).get<std::string>(); }
    template <class T, std::size_t N>
    void operator()(const char* key, T& v, const std::string_view (&words)[N]) const {
        const auto found = std::ranges::find(words, j.at(key).get<std::string>());
        if (found == std::end(words)) throw std::out_of_range{key};
        v = static_cast<T>(found - std::begin(words));
    }
};

// The keys of every kind of entry, for writing and for reading.
template <class A, class E>
void members(const A& each, E& e) {
    using T = std::remove_const_t<E>;
    if constexpr (std::same_as<T, CampaignChange>) {
        each("change", e.what, T::words);
        each("reason", e.reason);
        each("plan", e.plan);
        return;
    } else {
        each("point", e.point);
    }
    if constexpr (std::same_as<T, PointBegun>) {
        each("keeps_passes", e.keeps_passes);
    } else if constexpr (std::same_as<T, PassEnded>) {
        each("pass", e.pass);
        each("recording", e.recording);
        each("measurement", e.measurement);
        each("from_s", e.from_s);
        each("to_s", e.to_s);
        each("x_from_m", e.x_from_m);
        each("x_to_m", e.x_to_m);
        each("true_v_D_mps", e.true_v_D);
        each("how", e.how, T::words);
        each("reason", e.reason);
    } else if constexpr (std::same_as<T, PassLost>) {
        each("pass", e.pass);
        each("reason", e.reason);
    } else if constexpr (std::same_as<T, Returned>) {
        each("x_from_m", e.x_from_m);
        each("x_asked_m", e.x_asked_m);
        each("x_to_m", e.x_to_m);
        each("for_s", e.for_s);
    } else if constexpr (std::same_as<T, PointEnded>) {
        each("outcome", e.outcome, outcome_words);
        each("reason", e.reason);
    }
}

using What = decltype(JournalEntry::what);
constexpr std::string_view kinds[] = {"campaign",  "point begun", "pass ended",
                                      "pass lost", "point ended", "returned"};
static_assert(std::size(kinds) == std::variant_size_v<What>);

template <std::size_t... I>
What empty_entry(std::size_t kind, std::index_sequence<I...>) {
    What what;
    ((I == kind ? void(what.emplace<I>()) : void()), ...);
    return what;
}

std::optional<JournalEntry> entry_of(const std::string& line) try {
    const json j = json::parse(line);
    std::size_t kind = 0;
    Take{j}("what", kind, kinds);
    JournalEntry entry{{}, empty_entry(kind, std::make_index_sequence<std::size(kinds)>{})};
    Take{j}("time", entry.time);
    std::visit([&](auto& e) { members(Take{j}, e); }, entry.what);
    return entry;
} catch (const json::exception&) {
    return std::nullopt;
} catch (const std::out_of_range&) {
    return std::nullopt;
}

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw DeviceError{file.string() + ": " + std::generic_category().message(error)};
}

// Bytes up to the end of the last line that is an entry; the lines before it are checked when they are read.
std::int64_t whole_lines(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    const std::string text{std::istreambuf_iterator<char>{in}, {}};
    const std::size_t end = text.rfind('\n');
    if (end == std::string::npos) return 0;
    const std::size_t before = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
    const std::size_t last = before == std::string::npos ? 0 : before + 1;
    return static_cast<std::int64_t>(entry_of(text.substr(last, end - last)) ? end + 1 : last);
}

}  // namespace

std::string line_of(const JournalEntry& entry) {
    json j{{"time", entry.time}, {"what", kinds[entry.what.index()]}};
    std::visit([&](const auto& e) { members(Put{j}, e); }, entry.what);
    return j.dump(-1, ' ', false, json::error_handler_t::replace);
}

Journal::Journal(const std::filesystem::path& file)
    : file_{file},
      descriptor_{::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666)} {
    if (descriptor_ < 0) fail(file, errno);
    whole_ = whole_lines(file);
    if (::ftruncate(descriptor_, whole_) == 0 && ::fsync(descriptor_) == 0) return;
    fail(file, errno);
}

void Journal::add(const JournalEntry& entry) {
    const std::string line = line_of(entry) + '\n';
    // What an earlier failure left behind the last complete line.
    if (::ftruncate(descriptor_, whole_) != 0) fail(file_, errno);
    const ssize_t written = ::write(descriptor_, line.data(), line.size());
    const bool whole = written == static_cast<ssize_t>(line.size());
    if (whole && ::fdatasync(descriptor_) == 0) {
        whole_ += written;
        return;
    }
    const int error = written < 0 || whole ? errno : ENOSPC;
    // Otherwise the next reader drops it as an incomplete last line, and the next add() cuts it off.
    (void)::ftruncate(descriptor_, whole_);
    fail(file_, error);
}

ReadJournal parse_journal(const std::string& text, const std::string& file) {
    ReadJournal out;
    std::size_t number = 0;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at);
        const bool last = end == std::string::npos || end + 1 == text.size();
        const std::string line = text.substr(at, end == std::string::npos ? end : end - at);
        at = last ? text.size() : end + 1;
        ++number;
        std::optional<JournalEntry> entry;
        if (end != std::string::npos) entry = entry_of(line);
        if (entry) {
            out.entries.push_back(std::move(*entry));
        } else if (last) {
            out.remark = fmt::format(
                "{} line {}: incomplete, dropped; the campaign was interrupted while it was written", file,
                number);
        } else {
            throw InputError{
                fmt::format("{} line {}: not an entry of a campaign's journal; correct or remove this line",
                            file, number)};
        }
    }
    return out;
}

ReadJournal read_journal(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    if (!in) throw InputError{file.string() + ": cannot be read; a campaign's folder has this file"};
    return parse_journal({std::istreambuf_iterator<char>{in}, {}}, file.string());
}

}  // namespace shaker::campaign
