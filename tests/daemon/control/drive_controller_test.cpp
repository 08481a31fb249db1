// A drive that was locked is used again: at its set-point, and mirrored at that of its mirror partner.
#include "daemon/control/drive_controller.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace shaker::control {
namespace {

std::complex<double> response(double hz) { return std::polar(60.0, 0.4 - 0.01 * hz); }

// A base that makes a third harmonic of its own, and goes farther one way than the other.
Harmonics<Acceleration> base(const Harmonics<Voltage>& volts) {
    Harmonics<Acceleration> a;
    for (int q = 1; q <= max_harmonics; ++q) a.at(q) = 1.05 * response(20 * q) * volts.at(q);
    a.at(3) += 0.02 * a.at(1);
    a.at(2) += 0.003 * a.at(1) * a.at(1) / 9.8;
    return a;
}

/// Windows until the drive is locked; at most 300.
int lock(DriveController& controller) {
    for (int k = 1; k <= 300; ++k) {
        PeriodWindows::Window w{.estimate = {},
                                .motion = {base(controller.volts()), 1e-5, controller.volts(), true}};
        controller.take(w, true);
        controller.hold();
        if (controller.report().locked) return k;
    }
    return 300;
}

TEST(DriveControllerTest, PartnersBeginAtTheImageAndKeepTheirOwnDrives) {
    using std::numbers::pi;
    const Drive drive{.gamma = 9.8, .phi = 0.7};
    Drive partner = drive;
    partner.phi += pi;
    DriveController controller{{.drive = drive, .volts_limit = 10, .identify = false, .sheet = response}};
    controller.begin();
    ASSERT_LT(lock(controller), 300);
    const Harmonics<Voltage> locked = controller.volts();
    controller.set(partner);
    for (int q = 1; q <= max_harmonics; ++q)
        EXPECT_EQ(controller.volts().at(q), (q % 2 == 0 ? -1.0 : 1.0) * locked.at(q)) << q;
    EXPECT_LT(lock(controller), 300);
    const Harmonics<Voltage> own = controller.volts();
    for (int times = 0; times < 3; ++times) {
        controller.set(drive);
        EXPECT_EQ(controller.volts().a, locked.a) << "its own drive, not the partner's image";
        EXPECT_LE(lock(controller), 12);
        controller.set(partner);
        EXPECT_EQ(controller.volts().a, own.a);
        EXPECT_LE(lock(controller), 12);
    }
}

}  // namespace
}  // namespace shaker::control
