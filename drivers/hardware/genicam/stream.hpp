#pragma once
// GenicamStream: one connection to a GenICam camera, from opening to loss. Sets it up, starts it, receives
// its pictures.
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hardware/clock/exposure_counter.hpp"
#include "drivers/hardware/genicam/picture_buffers.hpp"
#include "drivers/hardware/genicam/setup.hpp"

namespace shaker::genicam {

/// One buffer from the stream.
struct ReceivedPicture {
    bool whole = false;            // no packet is missing
    std::shared_ptr<Frame> frame;  // null when broken or when no frame was free
    hardware::ExposureSign sign;   // valid if `whole`
};

/// One thread, except where stated.
class GenicamStream {
public:
    /// Opens and configures; see open_genicam.
    GenicamStream(const GenicamSettings& settings, const std::string& name);
    /// Stops the camera and returns all buffers. May take seconds when the camera does not answer.
    ~GenicamStream();
    GenicamStream(const GenicamStream&) = delete;
    GenicamStream& operator=(const GenicamStream&) = delete;

    [[nodiscard]] const GenicamPicture& picture() const noexcept;
    /// Granted and refused settings, one line each.
    [[nodiscard]] const std::vector<std::string>& granted() const noexcept;
    /// Starts the camera. The buffers must outlive this object.
    void start(PictureBuffers& buffers);
    /// The next buffer; empty when none came within `wait`.
    std::optional<ReceivedPicture> receive(std::chrono::microseconds wait);
    /// Exposes one picture if triggered by software. False when the camera did not answer.
    bool trigger() noexcept;
    /// Marks the camera as dead: commands to it are omitted as far as possible, because each takes seconds.
    void forsake() noexcept;
    /// True when the camera does not answer any more, or another program took control. Any thread.
    [[nodiscard]] bool control_lost() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::genicam
