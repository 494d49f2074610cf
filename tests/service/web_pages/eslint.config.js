// The rules of ESLint for the pages and their tests; run in the root of the repository.

import js from "@eslint/js";

export default [
  { ignores: ["**/vendor/**", "**/node_modules/**"] },
  js.configs.recommended,
  {
    languageOptions: {
      globals: Object.fromEntries([
        "AbortController", "AbortSignal", "Blob", "CompressionStream", "CustomEvent", "DataView", "DecompressionStream", "Event", "EventTarget", "Image", "ImageData",
        "Intl", "KeyboardEvent", "MutationObserver", "NodeFilter", "OffscreenCanvas", "PerformanceObserver",
        "Response", "ResizeObserver", "TextDecoder", "TextEncoder", "URL",
        "URLSearchParams", "VideoEncoder", "VideoFrame", "WebSocket", "Buffer", "addEventListener", "atob", "btoa", "clearInterval", "clearTimeout",
        "console", "createImageBitmap", "crypto", "devicePixelRatio", "dispatchEvent", "document", "fetch", "getComputedStyle", "history",
        "innerHeight", "innerWidth", "isSecureContext", "localStorage", "location", "matchMedia", "navigator", "performance", "process",
        "requestAnimationFrame", "scrollY", "sessionStorage", "setInterval", "setTimeout", "window",
      ].map((name) => [name, "readonly"])),
    },
    rules: {
      complexity: ["error", 17],
      eqeqeq: ["error", "always", { null: "ignore" }],
      "max-len": ["error", { code: 170 }],
      "no-restricted-properties": ["error", { property: "innerHTML" }, { property: "insertAdjacentHTML" }],
      "no-shadow": ["error", { allow: ["before"] }],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
    },
  },
];
