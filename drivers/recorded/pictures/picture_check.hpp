#pragma once
// Checks a camera's pictures after a crash, and ends their recording.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/recorded/pictures/picture_reader.hpp"

namespace shaker::pictures {

struct BadPicture {
    std::uint64_t number;  // from 1
    std::filesystem::path file;
    PictureFault fault;
};

struct PictureCheck {
    std::vector<std::uint64_t> whole;  // numbers of intact pictures, ascending
    std::uint64_t last = 0;            // the highest among them; 0: none
    /// In order of their numbers. Bad pictures up to `last` were lost or changed; those after it were in
    /// transit when the writer ended.
    std::vector<BadPicture> bad;
    std::vector<std::string> damaged;  // unreadable files, and the pictures missing with them
};

/// Reads every picture. InputError when nothing is readable.
PictureCheck verify_frames(const std::filesystem::path& folder, const std::string& camera);

/// Ends a recording: cuts the files after picture `last`, or releases their space on the disk when they are
/// nearly full, removes files without pictures, and writes the link file. A file is replaced by its shorter
/// copy or kept; unreadable files are kept. There must be no intact pictures after `last`, and no store that
/// writes into the folder. Returns the unreadable files, and the pictures missing with them. DeviceError when
/// the disk fails; the call can then be repeated.
std::vector<std::string> end_frames(const std::filesystem::path& folder, const std::string& camera, std::uint64_t last);

/// verify_frames(), then end_frames() after the last intact picture. Bad ones before it are kept and
/// reported. Repeating it changes nothing.
PictureCheck finish_frames(const std::filesystem::path& folder, const std::string& camera);

}  // namespace shaker::pictures
