#pragma once
// Units after numbers in SCPI notation: HZ KHZ S MS US V MV M/S2 G RAD DEG MM UM PCT DB and others.
#include <string>
#include <string_view>

namespace shaker::scpi {

enum class Dimension {
    number,  // has no unit
    frequency,
    time,
    voltage,
    current,
    force,
    acceleration,
    velocity,
    length,
    angle,
    ratio,
    temperature,
    other,  // accepts its own name only
};

/// The unit of a parameter: that of a number without a suffix, and of its replies.
class Unit {
public:
    /// "": a pure number. "1": a ratio, which accepts PCT and DB (20 log10). An unknown name such as "MM/PX"
    /// accepts only itself.
    explicit Unit(std::string_view name = {});

    /// Converts `value` in `suffix` to this unit. Upper or lower case; M is milli except in MHZ, as in SCPI.
    /// Throws Error: -131 with the accepted units, -138 if none is accepted.
    [[nodiscard]] double convert(double value, std::string_view suffix) const;

    /// As printed after a number: " HZ", or empty.
    [[nodiscard]] std::string label() const;
    [[nodiscard]] std::string understood() const;

private:
    std::string name_;  // in upper case
    Dimension dimension_ = Dimension::number;
    double times_ = 1, over_ = 1;  // to SI
};

}  // namespace shaker::scpi
