#include "daemon/manual/drive_arguments.hpp"

namespace shaker::manual {

Drive changed_drive(const Values& values, Drive drive) {
    const auto change = [&](const char* option, double& x) {
        if (values.has(option)) x = values.number(option);
    };
    change("--gamma", drive.gamma);
    change("--phi", drive.phi);
    change("--rho", drive.rho);
    change("--frequency", drive.frequency);
    return drive;
}

}  // namespace shaker::manual
