#pragma once
// Units behind numbers, as SCPI writes them: HZ KHZ S MS US V MV M/S2 G RAD DEG MM UM PCT DB and the like.
#include <string>
#include <string_view>

namespace shaker::scpi {

enum class Dimension {
    number,  // takes no unit
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
    other,  // takes its own name only
};

/// The unit of a parameter: what a bare number means, and what its replies are in.
class Unit {
public:
    /// "" is a pure number and "1" a ratio, of which PCT and DB (20 log10) are parts. A name that is not
    /// known, "MM/PX", understands itself only.
    explicit Unit(std::string_view name = {});

    /// `value` in `suffix` becomes one in this unit. Upper or lower case; M is milli but for MHZ, as SCPI has
    /// it. Throws Error: -131 with the units understood, -138 where none is.
    [[nodiscard]] double convert(double value, std::string_view suffix) const;

    /// As it is printed behind a number: " HZ", or nothing.
    [[nodiscard]] std::string label() const;
    [[nodiscard]] std::string understood() const;

private:
    std::string name_;  // in capitals
    Dimension dimension_ = Dimension::number;
    double times_ = 1, over_ = 1;  // to SI
};

}  // namespace shaker::scpi
