#include "daemon/command_line/harmonics_argument.hpp"

#include <algorithm>
#include <charconv>
#include <complex>
#include <string>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::command_line {

namespace {

constexpr Range amplitudes{0, 1e6}, phases{-100, 100};

int order_of(std::string_view option, std::string_view item, std::string_view text) {
    int q = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), q);
    if (error == std::errc{} && end == text.data() + text.size() && q >= 1 && q <= max_harmonics) return q;
    throw InputError{std::string{option} + " \"" + std::string{item} +
                     "\": the order of a harmonic is 1 to " + std::to_string(max_harmonics) +
                     "; expected ORDER:AMPLITUDE@PHASE, e.g. 2:4.9m/s^2@35deg"};
}

}  // namespace

Harmonics<Acceleration> parse_harmonics(std::string_view option, std::string_view text) {
    Harmonics<Acceleration> h;
    while (!text.empty()) {
        const std::string_view item = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), item.size() + 1));
        const std::size_t colon = std::min(item.find(':'), item.size());
        const int q = order_of(option, item, item.substr(0, colon));
        const std::string_view value = item.substr(std::min(colon + 1, item.size()));
        const std::size_t at = std::min(value.find('@'), value.size());
        const double amplitude =
            parse_quantity(option, value.substr(0, at), Dimension::acceleration, amplitudes);
        const double phase =
            at == value.size() ? 0 : parse_quantity(option, value.substr(at + 1), Dimension::angle, phases);
        if (h.at(q) != 0.0)
            throw InputError{std::string{option} + ": harmonic " + std::to_string(q) + " is given twice"};
        h.at(q) = std::polar(amplitude, phase);
    }
    return h;
}

}  // namespace shaker::command_line
