#include "daemon/service/order_texts.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <string_view>

#include "daemon/service/bench_port.hpp"
#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t longest_name = 64;

}  // namespace

void require_name(const std::string& name) {
    constexpr std::string_view more = "._-";
    const auto allowed = [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               more.find(c) != std::string_view::npos;
    };
    if (!name.empty() && name.size() <= longest_name && name.front() != '.' &&
        std::ranges::all_of(name, allowed))
        return;
    throw InputError{fmt::format(
        "recording \"{}\": expected 1 to {} letters, digits, dots, hyphens and underscores, without "
        "a dot in front",
        name.substr(0, longest_name), longest_name)};
}

void require_remark(const std::string& text) {
    if (!text.empty() && text.size() <= Remark::longest && printable(text) == text) return;
    throw InputError{
        fmt::format("remark of {} bytes: 1 to {} bytes of UTF-8 without control characters are "
                    "allowed",
                    text.size(), Remark::longest)};
}

}  // namespace shaker::service
