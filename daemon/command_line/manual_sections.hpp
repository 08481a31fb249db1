#pragma once
// Sections of the manual page of shakerd that no table describes.
#include <array>

#include "daemon/manual/command.hpp"

namespace shaker::command_line {

using Item = std::array<std::string_view, 2>;  // a term and its meaning

inline constexpr std::array file_items{
    Item{"/etc/shakerd/shakerd.toml", "Settings of the daemon as a service."},
    Item{"/var/lib/shakerd", "Recordings of the daemon as a service."},
    Item{"/usr/share/doc/shakerd",
         "README.md and the pages that messages and settings name, such as daemon/safety/LIMITS.md."},
    Item{"RUN.nxs",
         "A recording (HDF5, NeXus). Until it is finished, its name is RUN.nxs.part, with RUN.nxs.journal "
         "beside it; the "
         "pictures are in RUN.frames. After a crash, \"shakerd recover\" finishes it."},
    Item{"trip-TIME.nxs", "The last seconds of a run that a limit stopped and that was not recorded."}};

inline constexpr std::array signal_items{
    Item{"SIGTERM, SIGINT", "\"serve\" ramps the drive down softly, finishes the recording and exits."},
    Item{"SIGHUP", "\"serve\" reads its settings file again."},
    Item{"SIGKILL",
         "The DAC plays a ramp to zero that is always queued behind the drive. The data so far are in the "
         ".part file."}};

inline constexpr std::array manual_sections{
    manual::Section{.title = "FILES", .items = file_items},
    manual::Section{.title = "SIGNALS", .items = signal_items},
    manual::Section{.title = "NOTES", .paragraph = "Software is not the emergency stop."},
    manual::Section{.title = "SEE ALSO", .paragraph = "shakerctl(1)"},
};

}  // namespace shaker::command_line
