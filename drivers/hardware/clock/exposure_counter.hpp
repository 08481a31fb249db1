#pragma once
// ExposureCounter: numbers a camera's exposures, lost ones included. No I/O, no allocation.
#include <cstdint>
#include <optional>

#include "drivers/time.hpp"

namespace shaker::hardware {

/// Evidence that came with one picture.
struct ExposureSign {
    std::optional<std::uint64_t> id;   // on the camera's clock
    std::optional<CameraStamp> stamp;  // its clock
    HostTime arrived;
};

/// Position of one picture among the exposures.
struct ExposurePlace {
    CameraTick tick;
    std::int64_t missed = 0;  // number of exposures between the previous picture and this one
    bool gap = false;  // exposures are missing before it, or its tick is derived from the host's clock only
    bool clock_jumped = false;  // the camera's clock was set: stamps before and after are not comparable
};

/// Uses ids and stamps: ids show losses in transfer, stamps show exposures that the camera left out; the
/// larger number counts. A step of the stamps that contradicts the host's clock by more than half a second is
/// a step of the camera's clock; then only ids count.
class ExposureCounter {
public:
    /// GigE Vision 1 has ids of 16 bits that go from 65535 to 1; 0 means "no id". Wide ids do not wrap.
    enum class Ids { wrap_at_65535, wide };
    /// period_ns: time between exposures; 0: no fixed rate. pause_ns: with an external trigger, a longer
    /// silence without a gap in the ids is a pause of the trigger, not a loss; 0: the camera runs free and
    /// has no pauses.
    ExposureCounter(Ids ids, std::int64_t period_ns, std::int64_t pause_ns) noexcept
        : wide_{ids == Ids::wide}, period_ns_{period_ns}, pause_ns_{pause_ns} {}

    /// Call when the camera was opened again: its ids restart, possibly its clock too.
    void reopened() noexcept { reopened_ = true; }
    ExposurePlace next(const ExposureSign& sign) noexcept;

private:
    struct Last {
        ExposureSign sign;
        std::int64_t tick;
    };
    [[nodiscard]] std::int64_t id_step(const ExposureSign& sign) noexcept;
    [[nodiscard]] std::int64_t periods(std::int64_t ns) const noexcept;

    bool wide_;
    std::int64_t period_ns_;
    std::int64_t pause_ns_;
    bool reopened_ = false;
    std::optional<Last> last_;
};

}  // namespace shaker::hardware
