import { defineConfig } from 'vite';

/** Address of the server that `npm run dev` passes requests on to. */
const server = process.env.TABLETOPGEN_URL ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: '/studio/',
  build: {
    target: 'es2022',
    // The content security policy of the page allows no inline code, and no data as fonts or scripts.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    cssCodeSplit: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 800,
  },
  // The server serves this file with a policy of its own, and knows it by its name.
  worker: { format: 'es', rolldownOptions: { output: { entryFileNames: 'assets/physics-worker-[hash].js' } } },
  server: { proxy: { '^/(?!studio/)': { target: server, changeOrigin: true } } },
});
