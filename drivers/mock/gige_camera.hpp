#pragma once
// A GigE Vision camera in this process: any client on this computer finds, configures and streams it. Control
// channel, registers and GenICam description are served by Aravis' fake camera; the pictures, their time
// stamps and everything that goes wrong are ours. It behaves as one with a trigger line: a pushed picture is
// one exposure.
#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/data.hpp"

namespace shaker {

struct GigeCameraSettings {
    std::string address = "127.0.0.1";  // must be one of the loopback interface's own (see loopback.hpp)
    std::string serial = "MOCK";        // at most 15 characters; the camera's id is Shaker-Mock-<serial>
    int width = 512;                    // of the sensor, and of every picture; pixels
    int height = 96;
    std::uint16_t first_id = 1;  // block id of the first picture; 65535 is followed by 1
    std::size_t queue = 256;     // pictures that may wait for transmission
    unsigned seed = 1;           // of the packets that are lost on purpose
};

/// What the client has configured.
struct GigeRequest {
    bool acquiring = false;    // it controls the camera and has started it
    bool triggered = false;    // false: the camera runs free
    std::string source;        // "Line0", "Line1" or "Software"
    double frame_rate_hz = 0;  // of a free run
    double exposure_s = 0;
    double gain_dB = 0;
    std::array<int, 4> region_px{};  // x, y, width, height
    std::uint32_t pixel_format = 0;  // PFNC code
    bool ptp = false;
};

/// Every pushed picture is in exactly one of the others, or still waits.
struct GigeCounts {
    std::uint64_t pushed = 0;
    std::uint64_t transmitted = 0;  // with all its packets
    std::uint64_t damaged = 0;      // at least one packet was lost on purpose
    std::uint64_t dropped = 0;      // exposed but never transmitted: drop(), or still waiting at unplug()
    std::uint64_t overflow = 0;     // exposed but the queue was full
    std::uint64_t unasked = 0;      // not exposed: unplugged, not acquiring, or no software trigger came
};

/// push() from one thread, everything else from any.
class GigeCamera {
public:
    /// Throws DeviceError when the address or its GVCP port (3956) cannot be used, InputError for a wrong
    /// setting.
    explicit GigeCamera(const GigeCameraSettings& settings);
    ~GigeCamera();
    GigeCamera(const GigeCamera&) = delete;
    GigeCamera& operator=(const GigeCamera&) = delete;

    /// One exposure: queues the picture for transmission with this time on the camera's clock. 8-bit pictures
    /// are sent in full scale in whatever format the client asked for; 16-bit ones hold codes of that format
    /// and are clamped to its largest. Throws InputError when the picture is not of the sensor's size.
    void push(FramePtr frame, std::int64_t stamp_ns);
    [[nodiscard]] GigeRequest requested() const;
    [[nodiscard]] GigeCounts counts() const;
    /// Returns when no picture waits for transmission any more, or false after `wait_s`.
    bool drained(double wait_s) const;

    /// From now on each packet is lost with this probability.
    void lose(double ratio);
    /// Nothing is transmitted for this long; what was pushed meanwhile comes late, all at once.
    void stall(double seconds);
    /// The next `n` exposures are not transmitted; block ids go on as if they had been.
    void drop(std::uint64_t n);
    /// Added to the time stamps of all later pictures.
    void shift_stamps(std::int64_t ns);
    /// The cable is pulled: the camera answers nothing and forgets its settings and what it has not
    /// transmitted yet; plug() starts it afresh, block ids too. plug() may throw like the constructor.
    void unplug();
    void plug();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
