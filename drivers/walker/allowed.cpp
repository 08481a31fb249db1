#include "drivers/walker/allowed.hpp"

#include <sstream>

#include "drivers/errors.hpp"

namespace shaker::walker {

void require(bool good, const char* what, double value, const std::string& allowed) {
    if (good) return;
    std::ostringstream message;
    message << what << " is " << value << "; must be " << allowed;
    throw InputError{message.str()};
}

}  // namespace shaker::walker
