#pragma once
// Opens a GenICam camera, applies its settings and reports the granted ones.
#include <memory>
#include <string>
#include <vector>

#include "drivers/hardware/genicam/settings.hpp"

typedef struct _ArvCamera ArvCamera;  // NOLINT: Aravis' own name

namespace shaker::genicam {

struct UnrefCamera {
    void operator()(ArvCamera* camera) const noexcept;
};
using CameraHandle = std::unique_ptr<ArvCamera, UnrefCamera>;

/// Format of the pictures of an opened camera.
struct GenicamPicture {
    int width = 0;
    int height = 0;
    const PixelFormat* format = nullptr;
    std::size_t payload_bytes = 0;  // of one picture in the stream, chunks included
    bool chunks = false;            // it includes ChunkFrameID and ChunkTimestamp
    bool stamped = true;            // the camera has a clock
    bool wide_ids = false;          // frame ids do not wrap at 16 bits
    double exposure_s = 0;          // as granted
    bool operator==(const GenicamPicture&) const = default;
};

/// From now on, lines of GLib and Aravis go to the log's debug level instead of the terminal: a camera's
/// faulty description causes dozens. Errors reach the caller as DeviceError.
void log_lines_of_glib();

/// Opens and configures the camera called `name` in messages, without starting it. Appends lines like
/// "exposure 0.0005 s (requested 0.0005)" to `granted`. Throws DeviceError: not found, in use, or a refused
/// value with its allowed range.
CameraHandle open_genicam(const GenicamSettings& settings, const std::string& name, GenicamPicture& picture,
                          std::vector<std::string>& granted);

}  // namespace shaker::genicam
