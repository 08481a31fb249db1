#include "daemon/remote/scpi/reply.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {
namespace {

constexpr double not_a_number = 9.91e37, infinite = 9.9e37;

/// SCPI uses its own numbers for NaN and infinities, in blocks too.
double presentable(double value) noexcept {
    if (std::isnan(value)) return not_a_number;
    if (std::isinf(value)) return std::copysign(infinite, value);
    return value;
}

template <class Real>
std::array<char, sizeof(Real)> bytes_of(double value, bool swapped) noexcept {
    constexpr double largest = std::numeric_limits<Real>::max();
    const double fits =
        std::abs(value) > largest ? presentable(value > 0 ? HUGE_VAL : -HUGE_VAL) : presentable(value);
    auto bytes = std::bit_cast<std::array<char, sizeof(Real)>>(static_cast<Real>(fits));
    if (swapped != (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

}  // namespace

Reply::Reply(std::string& out, Format format, std::size_t limit)
    : out_{out}, format_{format}, limit_{limit} {}

void Reply::begin() {
    if (!empty_) put(",");
    empty_ = false;
}

void Reply::put(std::string_view text) {
    overflown_ = overflown_ || out_.size() + text.size() > limit_;
    if (!overflown_) out_ += text;
}

void Reply::number(double value) {
    if (std::isnan(value)) return word("9.91E37");
    if (std::isinf(value)) return word(value > 0 ? "9.9E37" : "-9.9E37");
    begin();
    std::array<char, 32> text{};
    const int behind_the_point = format_.data == Format::Data::real64 ? 16 : 8;
    char* const end =
        std::to_chars(text.begin(), text.end(), value, std::chars_format::scientific, behind_the_point).ptr;
    std::replace(text.begin(), end, 'e', 'E');
    put({text.data(), static_cast<std::size_t>(end - text.data())});
}

void Reply::integer(std::int64_t value) {
    begin();
    std::array<char, 24> text{};
    const char* const end = std::to_chars(text.begin(), text.end(), value).ptr;
    put({text.data(), static_cast<std::size_t>(end - text.data())});
}

void Reply::word(std::string_view text) {
    begin();
    put(text);
}

void Reply::string(std::string_view text) {
    begin();
    const std::string clean = printable(text, std::numeric_limits<std::size_t>::max());
    put("\"");
    for (std::size_t from = 0; from <= clean.size();) {
        const std::size_t quote = std::min(clean.find('"', from), clean.size());
        put(std::string_view{clean}.substr(from, quote - from));
        if (quote < clean.size()) put("\"\"");
        from = quote + 1;
    }
    put("\"");
}

void Reply::put_block_head(std::size_t length) {
    const std::string digits = std::to_string(length);
    put(std::string{'#'}.append(std::to_string(digits.size())).append(digits));
}

void Reply::block(std::string_view bytes) {
    begin();
    put_block_head(bytes.size());
    put(bytes);
}

void Reply::numbers(std::span<const double> values) {
    if (format_.data == Format::Data::ascii) {
        for (const double value : values) number(value);
        return;
    }
    begin();
    const bool wide = format_.data == Format::Data::real64;
    put_block_head(values.size() * (wide ? sizeof(double) : sizeof(float)));
    for (const double value : values) {
        if (wide) {
            const auto bytes = bytes_of<double>(value, format_.swapped);
            put({bytes.data(), bytes.size()});
        } else {
            const auto bytes = bytes_of<float>(value, format_.swapped);
            put({bytes.data(), bytes.size()});
        }
    }
}

}  // namespace shaker::scpi
