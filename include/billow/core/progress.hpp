// How long work tells how far it is.
#pragma once

#include <functional>
#include <string_view>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

/// Called from the calling thread with the stage's name and the share of it that is done, 0 to 1.
/// An empty function asks for no reports.
using progress_function = std::function<void(std::string_view stage, double share)>;

/// Reports when somebody listens.
inline void report(const progress_function& progress, std::string_view stage, double share) {
    if (progress) progress(stage, share);
}

}  // namespace billow::inline BILLOW_ABI
