#include "daemon/remote/scpi/unit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/text.hpp"
#include "drivers/drive.hpp"

namespace shaker::scpi {
namespace {

// A factor in two parts: "50MS" is 50 / 1000, rounded once, where 50 * 0.001 would be rounded twice.
struct Known {
    std::string_view name;
    Dimension dimension;
    double times;
    double over;
};

constexpr std::array known = std::to_array<Known>({
    {"HZ", Dimension::frequency, 1, 1},
    {"KHZ", Dimension::frequency, 1e3, 1},
    {"MHZ", Dimension::frequency, 1e6, 1},
    {"S", Dimension::time, 1, 1},
    {"MS", Dimension::time, 1, 1e3},
    {"US", Dimension::time, 1, 1e6},
    {"NS", Dimension::time, 1, 1e9},
    {"MIN", Dimension::time, 60, 1},
    {"HR", Dimension::time, 3600, 1},
    {"V", Dimension::voltage, 1, 1},
    {"MV", Dimension::voltage, 1, 1e3},
    {"UV", Dimension::voltage, 1, 1e6},
    {"A", Dimension::current, 1, 1},
    {"MA", Dimension::current, 1, 1e3},
    {"N", Dimension::force, 1, 1},
    {"M/S2", Dimension::acceleration, 1, 1},
    {"MM/S2", Dimension::acceleration, 1, 1e3},
    {"G", Dimension::acceleration, paper_g, 1},
    {"MG", Dimension::acceleration, paper_g, 1e3},
    {"M/S", Dimension::velocity, 1, 1},
    {"MM/S", Dimension::velocity, 1, 1e3},
    {"UM/S", Dimension::velocity, 1, 1e6},
    {"M", Dimension::length, 1, 1},
    {"MM", Dimension::length, 1, 1e3},
    {"UM", Dimension::length, 1, 1e6},
    {"NM", Dimension::length, 1, 1e9},
    {"RAD", Dimension::angle, 1, 1},
    {"MRAD", Dimension::angle, 1, 1e3},
    {"DEG", Dimension::angle, std::numbers::pi, 180},
    {"1", Dimension::ratio, 1, 1},
    {"PCT", Dimension::ratio, 1, 1e2},
    {"CEL", Dimension::temperature, 1, 1},
});

const Known* find(std::string_view name) {
    const auto* found =
        std::find_if(known.begin(), known.end(), [&](const Known& row) { return same(name, row.name); });
    return found == known.end() ? nullptr : found;
}

}  // namespace

Unit::Unit(std::string_view name) {
    for (const char c : name) name_ += upper(c);
    if (name_.empty()) return;
    dimension_ = Dimension::other;
    if (const Known* row = find(name_)) {
        dimension_ = row->dimension;
        times_ = row->times;
        over_ = row->over;
    }
}

double Unit::convert(double value, std::string_view suffix) const {
    if (suffix.empty()) return value;
    if (dimension_ == Dimension::number)
        throw Error{Code::suffix_not_allowed, printable(suffix) + ", no unit is allowed here"};
    if (same(suffix, name_)) return value;
    double times = over_, over = times_;
    if (dimension_ == Dimension::ratio && same(suffix, "DB")) {
        value = std::pow(10, value / 20);
    } else {
        const Known* row = find(suffix);
        if (row == nullptr || row->dimension != dimension_ || row->name == "1")
            throw Error{Code::invalid_suffix, printable(suffix) + ", understood: " + understood()};
        times *= row->times;
        over *= row->over;
    }
    return value * times / over;
}

std::string Unit::label() const { return name_.empty() || name_ == "1" ? "" : " " + name_; }

std::string Unit::understood() const {
    std::string list;
    const auto add = [&](std::string_view name) {
        if (!list.empty()) list += ' ';
        list += name;
    };
    if (dimension_ == Dimension::other) add(name_);
    for (const Known& row : known)
        if (row.dimension == dimension_ && row.name != "1") add(row.name);
    if (dimension_ == Dimension::ratio) add("DB");
    return list;
}

}  // namespace shaker::scpi
