#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_H_

#include <cstdint>

namespace procgen {

// What follows the step that ends an episode, by Gymnasium's names.
enum class EpisodeEnd : int32_t {
  kSameStep =
      0,  // the next level is there at once; its first observation is answered (as released)
  kNextStep = 1,  // the last observation is answered; the next step ignores its action and begins
                  // the next level
  kDisabled = 2,  // the last observation is answered; stepping again without a reset is an error
};

class Environment;

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
