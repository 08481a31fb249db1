#include "drivers/point_fields.hpp"

#include <cmath>

namespace shaker {

double PointField::in(const PointSettings& point) const {
    if (const auto* of_drive = std::get_if<double Drive::*>(&member)) return point.drive.**of_drive;
    if (const auto* number = std::get_if<int PointSettings::*>(&member)) return point.**number;
    return point.*std::get<double PointSettings::*>(member);
}

void PointField::set(PointSettings& point, double value) const {
    if (const auto* of_drive = std::get_if<double Drive::*>(&member))
        point.drive.** of_drive = value;
    else if (const auto* number = std::get_if<int PointSettings::*>(&member))
        point.** number = static_cast<int>(std::lround(value));
    else
        point.*std::get<double PointSettings::*>(member) = value;
}

}  // namespace shaker
