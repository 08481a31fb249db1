#pragma once
// Opens a GenICam camera and sets it up as a rig file asks; tells what it granted.
#include <memory>
#include <string>
#include <vector>

#include "drivers/hardware/genicam_settings.hpp"

typedef struct _ArvCamera ArvCamera;  // NOLINT: Aravis' own name

namespace shaker {

struct UnrefCamera {
    void operator()(ArvCamera* camera) const noexcept;
};
using CameraHandle = std::unique_ptr<ArvCamera, UnrefCamera>;

/// What an opened camera sends.
struct GenicamPicture {
    int width = 0;
    int height = 0;
    const PixelFormat* format = nullptr;
    std::size_t payload_bytes = 0;  // of one picture on the stream, chunks included
    bool chunks = false;            // ChunkFrameID and ChunkTimestamp are in it
    bool stamped = true;            // the camera has a clock
    bool wide_ids = false;          // frame ids do not wrap at 16 bits
    double exposure_s = 0;          // as granted
    bool operator==(const GenicamPicture&) const = default;
};

/// Opens and configures the camera called `name` in messages; it does not run yet. Lines like "exposure
/// 0.0005 s (asked 0.0005)" are appended to `granted`. Throws DeviceError: not there, in use, or the value
/// that it refuses and the range that it has.
CameraHandle open_genicam(const GenicamSettings& settings, const std::string& name, GenicamPicture& picture,
                          std::vector<std::string>& granted);

}  // namespace shaker
