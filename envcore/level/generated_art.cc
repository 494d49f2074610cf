#include "envcore/level/generated_art.h"
namespace procgen {
GeneratedArt GenerateBackground(RandomStream&) { return {}; }
}  // namespace procgen
