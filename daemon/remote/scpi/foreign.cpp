#include "daemon/remote/scpi/foreign.hpp"

#include <algorithm>
#include <array>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {
namespace {

// Fields without a hyphen that a browser sends. No mnemonic contains a hyphen.
constexpr std::array<std::string_view, 6> fields{"HOST",   "ORIGIN", "REFERER",
                                                 "COOKIE", "ACCEPT", "CONNECTION"};

bool is_field(std::string_view name) noexcept {
    if (name.find('-') != std::string_view::npos) return true;
    return std::ranges::any_of(fields, [&](std::string_view field) { return same(name, field); });
}

std::string_view without_blanks(std::string_view line) noexcept {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    return line;
}

}  // namespace

bool is_binary(char first) noexcept {
    return static_cast<unsigned char>(first) < ' ' && first != '\r' && first != '\n' && first != '\t';
}

bool begins_like_http(std::string_view line) noexcept {
    line = without_blanks(line);
    const auto is_name = [](char c) { return is_letter(c) || c == '-'; };
    const auto size = static_cast<std::size_t>(std::ranges::find_if_not(line, is_name) - line.begin());
    const std::string_view name = line.substr(0, size);
    const std::string_view rest = line.substr(size);
    if (name.empty() || rest.empty()) return false;
    if (rest.front() == ':') return is_field(name);
    if (!is_blank(rest.front())) return false;
    const std::string_view target = without_blanks(rest);
    return target.starts_with('/') || same(target.substr(0, 4), "HTTP");
}

bool is_http_line(std::string_view line) noexcept {
    if (begins_like_http(line)) return true;
    line = without_blanks(line);
    const std::size_t slash = line.rfind('/');
    if (slash == std::string_view::npos || slash < 5) return false;
    const std::string_view version = line.substr(slash + 1);
    const auto is_version = [](char c) { return is_digit(c) || c == '.'; };
    return same(line.substr(slash - 4, 4), "HTTP") && is_blank(line[slash - 5]) && !version.empty() &&
           std::ranges::all_of(version, is_version);
}

}  // namespace shaker::scpi
