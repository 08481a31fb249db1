#pragma once
// Hard scenes of the walker, by name.
#include <numbers>

#include "tests/support/walker/walker_settings.hpp"

namespace shaker::scenes {

/// 400 periods (20 s) after a start at rest v is still 3.4e-4 gamma/omega from its cycle: "has it settled?"
/// must be measured.
inline walker::WalkerSetting slow_settling() { return paper_setting(40, 0); }

/// Sticks for 25/4000 of each period.
inline walker::WalkerSetting brief_stick() { return paper_setting(2, 3 * std::numbers::pi / 4); }

/// Just above the onset of drift: sticks for 20 % of the period, and the no-stick formula has the wrong sign.
inline walker::WalkerSetting threshold() { return paper_setting(0.5, 0); }

/// At this phase the drift changes sign between 0.68 g and 1 g.
inline walker::WalkerSetting sign_flip(double gamma_in_g) {
    return paper_setting(gamma_in_g, 3 * std::numbers::pi / 4);
}

}  // namespace shaker::scenes
