// Options of environments: by upstream's names in links and traces, as fields of EnvironmentOptions in messages.

const MODES = ["", "easy", "hard", "extreme", "memory", "exploration"];  // by number of DistributionMode

// In the order of trace files, with upstream's defaults. `variant` is not upstream's.
const DEFAULTS = {
  num_levels: 0, start_level: 0, rand_seed: 0, use_sequential_levels: false, center_agent: true, use_backgrounds: true,
  restrict_themes: false, use_monochrome_assets: false, use_generated_assets: false, paint_vel_info: false, debug_mode: 0,
  variant: "",
};

// Whether each of the options is there with a value of its type.
export function areOptions(values) {
  return Object.entries(DEFAULTS).every(([name, usual]) =>
    typeof values[name] === typeof usual && (typeof usual !== "number" || Number.isSafeInteger(values[name])));
}

export function nameOfMode(number) {
  return MODES[number] ?? `mode ${number}`;
}

// The number of a mode; 0 if there is none of this name.
export function numberOfMode(name) {
  return Math.max(0, MODES.indexOf(name));
}

// use_backgrounds -> useBackgrounds
function fieldOf(name) {
  return name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
}

// Fields of EnvironmentOptions. `options`: values by name, missing ones are defaults, unknown ones are ignored.
export function optionsMessage(mode, options) {
  const known = Object.entries(options).filter(([name]) => name in DEFAULTS);
  const fields = known.map(([name, value]) => [fieldOf(name), name === "rand_seed" ? BigInt(value) : value]);
  return { distributionMode: numberOfMode(mode), ...Object.fromEntries(fields) };
}

// The mode and all options of an EnvironmentOptions: { mode, options: values by name }.
export function optionsOf(message) {
  const values = Object.entries(DEFAULTS).map(([name, usual]) => {
    const value = message[fieldOf(name)] ?? usual;
    return [name, typeof value === "bigint" ? Number(value) : value];
  });
  return { mode: nameOfMode(message.distributionMode), options: Object.fromEntries(values) };
}
