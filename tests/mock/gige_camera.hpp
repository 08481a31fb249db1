#pragma once
// GigeCamera: a GigE Vision camera in this process, visible to any client on this computer. Aravis' fake
// camera serves the control channel, registers and GenICam description; pictures, time stamps and faults are
// implemented here. It behaves like a camera with a trigger line: a pushed picture is one exposure.
#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/data.hpp"

namespace shaker::mock {

struct GigeCameraSettings {
    std::string address = "127.0.0.1";  // an address of the loopback interface (see loopback.hpp)
    std::string serial = "MOCK";        // at most 15 characters; the camera's id is Shaker-Mock-<serial>
    int width = 512;                    // px, of the sensor and of every picture
    int height = 96;
    std::uint16_t first_id = 1;  // block id of the first picture; 65535 is followed by 1
    std::size_t queue = 256;     // pictures that may wait for transmission
    unsigned seed = 1;           // for packets lost on purpose
};

/// Settings made by the client.
struct GigeRequest {
    bool acquiring = false;    // a client controls the camera and has started it
    bool triggered = false;    // false: the camera runs free
    std::string source;        // "Line0", "Line1" or "Software"
    double frame_rate_hz = 0;  // of a free run
    double exposure_s = 0;
    double gain_dB = 0;
    std::array<int, 4> region_px{};  // x, y, width, height
    std::uint32_t pixel_format = 0;  // PFNC code
    bool ptp = false;
    std::uint16_t stream_port = 0;  // UDP port of the client that takes pictures
};

/// Every pushed picture is counted in exactly one of the other fields, or is waiting.
struct GigeCounts {
    std::uint64_t pushed = 0;
    std::uint64_t transmitted = 0;  // complete
    std::uint64_t damaged = 0;      // at least one packet was lost on purpose
    std::uint64_t dropped = 0;      // exposed but never sent: drop(), or waiting at unplug()
    std::uint64_t overflow = 0;     // exposed but the queue was full
    std::uint64_t unasked = 0;      // not exposed: unplugged, not acquiring, or without software trigger
};

/// push(): one thread; all others: any thread.
class GigeCamera {
public:
    /// Throws DeviceError when the address or its GVCP port (3956) cannot be used, InputError for a wrong
    /// setting.
    explicit GigeCamera(const GigeCameraSettings& settings);
    ~GigeCamera();
    GigeCamera(const GigeCamera&) = delete;
    GigeCamera& operator=(const GigeCamera&) = delete;

    /// One exposure: queues the picture with this time on the camera's clock. 8-bit pictures are sent at full
    /// scale in the format set by the client; 16-bit pictures hold codes of that format and are clamped to
    /// its largest. Throws InputError if the picture does not have the sensor's size.
    void push(FramePtr frame, std::int64_t stamp_ns);
    [[nodiscard]] GigeRequest requested() const;
    [[nodiscard]] GigeCounts counts() const;
    /// True when no picture waits for transmission any more; false after `wait_s`.
    bool drained(double wait_s) const;

    /// Loses each packet with this probability from now on.
    void lose(double ratio);
    /// Sends nothing for this long; pictures pushed meanwhile are sent afterwards, all at once.
    void stall(double seconds);
    /// Does not send the next `n` exposures; their block ids are used up.
    void drop(std::uint64_t n);
    /// Shifts the time stamps of all later pictures.
    void shift_stamps(std::int64_t ns);
    /// Pulls the cable: the camera does not answer, and its settings and waiting pictures are lost. plug()
    /// restarts it, with new block ids; it may throw like the constructor.
    void unplug();
    void plug();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::mock
