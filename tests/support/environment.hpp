#pragma once
// Sets environment variables for the programs that a test starts.
#include <cstdlib>
#include <map>
#include <string>

namespace shaker::test {

class Environment {
public:
    explicit Environment(const std::map<std::string, std::string>& variables) : variables_{variables} {
        for (const auto& [name, value] : variables_) ::setenv(name.c_str(), value.c_str(), 1);
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;
    ~Environment() {
        for (const auto& [name, value] : variables_) ::unsetenv(name.c_str());
    }

private:
    std::map<std::string, std::string> variables_;
};

}  // namespace shaker::test
