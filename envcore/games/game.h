#ifndef ENVCORE_GAMES_GAME_H_
#define ENVCORE_GAMES_GAME_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/types/span.h"
#include "envcore/games/game_options.h"
#include "envcore/level/generated_art.h"
#include "envcore/random/random_stream.h"
#include "envcore/scene/art_slot.h"
#include "envcore/scene/scene.h"
#include "envcore/state/state_archive.h"
#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// The facts about a game's art that are rules: the number of themes of a kind decides draws, and
// the aspect ratio of its images decides sizes.
struct GameArtSpec {
  absl::Span<const ArtSlot> slots;                // of this game, without the shared slots
  absl::Span<const int> block_shaped_kinds = {};  // their generated art fills the whole canvas
  absl::Span<const int> kept_theme_kinds = {};    // not affected by restrict_themes
  BackgroundGroup background_group = BackgroundGroup::kPlatform;
  float background_tile_ratio = 0;
  bool background_scrolls = false;  // moves to the left over time
};

// The result of one step.
struct StepOutcome {
  float reward = 0;
  bool done = false;            // the game ended the level
  bool level_complete = false;  // the level was also completed
};

// A game: its rules over one world, and what the world looks like. A game derives from this class,
// generates levels (MakeLevel), plays steps (PlayStep) and implements Rules. This class contains
// what all games share. A game does not know episodes: each StartLevel begins the next level.
// Threads: compatible (one thread at a time).
class Game : public Rules {
 public:
  // `art` must outlive the game.
  Game(const GameArtSpec& art, const GameOptions& options);

  // Begins the level with this seed.
  void StartLevel(int32_t level_seed);
  // Plays one step. `action`: in [0, kActionCount).
  void Play(int32_t action);

  // Saves or restores the state that changes while a level is played. `step_number_max`: largest
  // valid step number. State that the level seed determines is not visited. REQUIRES when
  // restoring: StartLevel was called with the seed of the saved level.
  void VisitState(StateArchive& archive, int32_t step_number_max);

  const StepOutcome& outcome() const { return outcome_; }
  // Number of steps played in this level.
  int32_t step_number() const { return step_number_; }
  const GameArtSpec& art() const { return art_; }
  const GameOptions& options() const { return options_; }
  const World& world() const { return world_; }
  const RandomStream& random() const { return random_; }
  // Whether the agent's center is in a cell that blocks the agent, or outside the grid.
  bool AgentIsInBlock();

  // Fills `scene` with what is visible now. The scene refers to this game and is valid until the
  // game changes.
  void FillScene(Scene* scene) const;
  // As FillScene, with the camera that shows the whole world.
  void FillLevelScene(Scene* scene);

 protected:
  // Generates a level. Calls StandardReset first.
  virtual void MakeLevel() = 0;
  // Plays one step. Calls StandardStep first.
  virtual void PlayStep() = 0;

  // The standard reset: draws the background, removes all entities, adds the agent (at a drawn
  // position with kRandom) and makes all cells empty.
  enum class AgentStart { kRandom, kFixed };
  void StandardReset(int width, int height, AgentStart agent_start = AgentStart::kRandom);
  // The standard step: controls, agent velocity, motion, contacts, removal.
  void StandardStep();
  // Moves every entity, from last to first, without contacts and removal.
  void MoveEntities();

  // Visits the game's own members that change while a level is played or that survive it. Also
  // checks restored values that could break the game's invariants. Default: none.
  virtual void VisitOwnState(StateArchive& /*archive*/) {}
  // Largest number of entities in a snapshot.
  virtual size_t EntityCountMax() const;

  // Changes the controls, which contain the direction of the action, for this game.
  virtual void MapControls() {}
  // Updates the agent's velocity from the controls. Not called with whole-cell motion.
  virtual void UpdateAgentVelocity();

  // The default rules: walls and everything outside the world block, nothing reflects, contacts
  // have no effect.
  bool Blocks(const Entity& mover, int kind, Axis axis) override;
  bool Reflects(const Entity& mover, int kind) override;
  void OnAgentContact(Entity& other) override;
  void OnEntityContact(Entity& self, Entity& other) override;
  void OnCellContact(Entity& entity, int kind, int x, int y) override;

  // The camera. Default: centered on the agent, or showing the whole world.
  virtual Camera MakeCamera() const;
  // The image kind of an entity. Negative: the entity is not drawn.
  virtual int ImageKindOf(const Entity& entity) const;
  // Changes the sprite of an entity before it is drawn.
  virtual void StyleSprite(const Entity& entity, Sprite* sprite) const;
  // Adds shapes on top of everything else. Default: none.
  virtual void AddOverlays(std::vector<Overlay>* overlays) const;

  // The number of themes of a kind, and a draw among them (one draw even if there is only one).
  int ThemeCount(int kind) const;
  int DrawTheme(int kind) { return random_.Int(ThemeCount(kind)); }
  // The value of a variant, where it is the options' one; else `upstream`.
  float ValueOf(Variant variant, float upstream) const {
    return options_.variant == variant ? options_.variant_value : upstream;
  }
  // Width / height of the image of a kind and theme in the art of Procgen 0.10.7.
  float AspectRatio(int kind, int theme) const;

  // True: the camera is centered on the agent and shows `cells_in_view_` cells across. False: it
  // shows the whole world.
  bool center_agent_;
  float cells_in_view_ = 16;
  // Standard velocity update: weight of the new velocity, and top speed. The jump speed only scales
  // the velocity display.
  float mix_ = 0.5F;
  float top_speed_ = 0.5F;
  float jump_speed_ = 0.5F;
  bool shows_velocity_ = true;
  // The look of each kind of cell. In a new level every kind shows its own image in theme 0.
  std::array<CellAppearance, kKindCount> cell_looks_;
  // The kind of cell that is drawn as a flat dot. Default: none.
  CellDots cell_dots_;

  RandomStream random_;  // of the level, seeded with the level seed
  World world_;
  StepOutcome outcome_;
  int32_t special_action_ = 0;  // 0: none; 1 to 6: actions 9 to 14
  int32_t last_move_ = 7;       // last move other than "none"; survives levels
  int32_t background_index_ = 0;

 private:
  // Fails if there is an entity of a kind that blocks movers. Only cells may block: motion between
  // many blocking entities would take practically forever.
  void CheckNoneBlocks(StateArchive& archive);
  const ArtSlot* FindSlot(int kind, int theme) const;
  // The theme that is shown for a stored one: 0 if themes are restricted.
  int ShownTheme(int kind, int theme) const;
  void AddSprites(int layer, std::vector<Sprite>* sprites) const;
  void FillCells(const Camera& camera, CellLayer* cells) const;

  const GameArtSpec& art_;
  const GameOptions options_;
  int32_t step_number_ = 0;
  int32_t move_ = kNoAction;
  float background_offset_ = 0;
  GeneratedArt generated_background_;
};

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_H_
