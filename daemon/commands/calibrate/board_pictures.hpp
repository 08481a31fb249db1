#pragma once
// Pictures of a board: from files, or from a live camera while an operator moves the board.
#include <functional>
#include <string>
#include <vector>

#include "calibration/camera/plane_fit.hpp"
#include "daemon/manual/values.hpp"

namespace shaker::commands {

struct BoardOptions {
    optics::Board board{};
    double thickness_mm = 0;  // of the board: its face lies so high on the base
    double raised_mm = 0;     // height of the raised board's underside; 0: none
};

struct BoardPictures {
    View view{};  // by the rig file; for pictures from files only name, direction and distance are set
    std::vector<calibration::PlacedBoard> boards{};
};

/// Finds the board in image files. InputError names the file.
std::vector<calibration::PlacedBoard> boards_in(const std::vector<std::string>& files,
                                                const BoardOptions& options, double offset_mm);

/// Opens the rig (--rig, --scene, --camera, --pictures); nothing is driven. A picture is taken when the board
/// has been moved since the last one and has been at rest for --hold; `show` receives a line. InputError when
/// none was taken for 5 min.
BoardPictures lead_board(const manual::Values& values, const BoardOptions& options,
                         const std::function<void(const std::string&)>& show);

}  // namespace shaker::commands
