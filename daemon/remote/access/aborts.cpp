#include "daemon/remote/access/aborts.hpp"

#include "daemon/remote/access/server_clock.hpp"

namespace shaker::access {

Aborts::Receipt Aborts::give(const std::string& by) {
    const std::uint64_t number = output_.stop(by);
    if (given_) given_(by);
    return [obeyed = output_.obeyed, number, given = ServerClock::now()] {
        if (obeyed() >= number) return Answer::obeyed;
        return ServerClock::now() - given < patience ? Answer::none : Answer::silent;
    };
}

}  // namespace shaker::access
