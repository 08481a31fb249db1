#pragma once
#include <string>

namespace shaker::ctl {

/// shakerctl(1), in the words of man(7).
std::string manual();

}  // namespace shaker::ctl
