#include "envcore/level/generated_art.h"

namespace procgen {

// Generated art is not there yet: its levels differ from the released ones.
GeneratedArt GenerateBackground(RandomStream& /*random*/) { return {}; }

}  // namespace procgen
