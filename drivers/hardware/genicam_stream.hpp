#pragma once
// One connection to a GenICam camera, from opening to loss: sets it up, runs it, receives its pictures.
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hardware/exposure_counter.hpp"
#include "drivers/hardware/genicam_setup.hpp"
#include "drivers/hardware/picture_buffers.hpp"

namespace shaker {

/// One buffer out of the stream.
struct ReceivedPicture {
    bool whole = false;            // no packet is missing
    std::shared_ptr<Frame> frame;  // null when broken, or when no frame was free
    ExposureSign sign;             // of a whole one
};

/// One thread, except where told otherwise.
class GenicamStream {
public:
    /// Opens and configures; see open_genicam.
    GenicamStream(const GenicamSettings& settings, const std::string& name);
    /// Stops the camera and returns all buffers. May wait for seconds when the camera does not answer.
    ~GenicamStream();
    GenicamStream(const GenicamStream&) = delete;
    GenicamStream& operator=(const GenicamStream&) = delete;

    [[nodiscard]] const GenicamPicture& picture() const noexcept;
    /// What was granted, and what was refused, in words.
    [[nodiscard]] const std::vector<std::string>& granted() const noexcept;
    /// Lets the camera run. The buffers must outlive this.
    void start(PictureBuffers& buffers);
    /// The next buffer, or nothing within `wait`.
    std::optional<ReceivedPicture> receive(std::chrono::microseconds wait);
    /// Exposes one picture when it is triggered by software. Returns false when the camera did not answer.
    bool trigger() noexcept;
    /// The camera is taken for dead: nothing more is said to it than must be, since each word takes seconds.
    void forsake() noexcept;
    /// The camera does not answer any more, or somebody else took it. Any thread.
    [[nodiscard]] bool control_lost() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
