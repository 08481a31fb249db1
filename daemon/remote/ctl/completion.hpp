#pragma once
#include <string>

namespace shaker::ctl {

/// What makes `shell` ("bash", "zsh", "fish") complete commands, options and values of shakerctl.
std::string completion(const std::string& shell);

}  // namespace shaker::ctl
