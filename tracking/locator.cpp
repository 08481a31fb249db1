#include "tracking/locator.hpp"

#include "tracking/bars_locator.hpp"
#include "tracking/code_locator.hpp"
#include "tracking/disc_locator.hpp"
#include "tracking/dots_locator.hpp"
#include "tracking/patch_locator.hpp"
#include "tracking/rectangle_locator.hpp"

namespace shaker::tracking {

std::unique_ptr<Locator> make_locator(const View& view, std::size_t index) {
    Subject subject = subject_of(view, view.targets.at(index));
    switch (subject.target.kind) {
        case TargetKind::disc:
            return std::make_unique<DiscLocator>(std::move(subject));
        case TargetKind::rectangle:
            return std::make_unique<RectangleLocator>(std::move(subject));
        case TargetKind::dots:
            if (subject.target.pitch_mm > 0) return std::make_unique<DotsLocator>(std::move(subject));
            return std::make_unique<DiscLocator>(std::move(subject));
        case TargetKind::bars:
            return std::make_unique<BarsLocator>(std::move(subject));
        case TargetKind::code:
            return std::make_unique<CodeLocator>(std::move(subject));
        case TargetKind::patch:
            return std::make_unique<PatchLocator>(std::move(subject));
    }
    throw InputError{subject.label + ": unknown kind"};
}

}  // namespace shaker::tracking
