#include "drivers/hardware/video/settings.hpp"

namespace shaker::video {

VideoSettings read_video_settings(SettingsTable& table) {
    VideoSettings s;
    if (table.has("device") == table.has("file"))
        table.fail("", "expected either device = \"/dev/video...\" or file = \"a movie\"");
    s.device = table.text("device", "");
    if (const std::filesystem::path file = table.text("file", ""); !file.empty())
        s.file = table.folder() / file;
    s.width = table.integer("width_px", 0, 65536, 0);
    s.height = table.integer("height_px", 0, 65536, 0);
    if ((s.width == 0) != (s.height == 0)) table.fail("width_px", "requires height_px, and the reverse");
    s.frame_rate_hz = table.number("frame_rate_hz", {0, 100000}, 0);
    s.exposure_s = table.number("exposure_s", {0, 10}, 0);
    s.paced = table.choice("pace", {"rate", "fast"}, 0) == 0;
    return s;
}

}  // namespace shaker::video
